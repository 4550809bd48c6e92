"""The driver against the emulated arm in virtual time: one thread, no network, one life a seed."""
