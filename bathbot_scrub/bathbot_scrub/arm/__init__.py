"""What every arm has: the protocol, limits, tool paths, clearance, states, force limits, errors."""
