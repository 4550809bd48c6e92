"""From views to a calibration file that was judged."""
