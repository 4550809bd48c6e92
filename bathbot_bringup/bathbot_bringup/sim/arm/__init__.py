"""The simulated RM65: controller, protocol, contact."""
