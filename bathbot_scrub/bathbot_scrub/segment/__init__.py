"""What the planner hands to the driver of an arm: a path in segments."""
