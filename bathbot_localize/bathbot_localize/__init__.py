"""From a skin region to a contact target in the frame of the robot (paper, sections 2.1.3 and 2.1.4)."""
