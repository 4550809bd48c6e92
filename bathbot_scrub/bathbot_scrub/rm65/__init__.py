"""The RM65-6F: the arm, the controller's protocol, jerk-limited motion, force guard, driver."""
