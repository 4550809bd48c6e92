"""The topic names and messages of the vendor's ROS 2 driver, for programs written against it."""
