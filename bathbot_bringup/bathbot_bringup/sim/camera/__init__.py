"""The simulated D455."""
