"""The RM65-6F arm: kinematics, the controller's protocol, jerk-limited motion, force guard, driver."""
