"""The arm in the graph: messages, telemetry and the driver node."""
