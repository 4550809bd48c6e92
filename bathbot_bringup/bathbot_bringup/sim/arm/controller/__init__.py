"""The controller's inside: motion, joints, force."""
