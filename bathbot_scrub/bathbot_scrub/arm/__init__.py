"""What every arm is to its users: the protocol, limits, tool paths, clearance, states and errors."""
