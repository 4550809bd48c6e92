"""Errors a user can mend. Every message says what is wrong, the value seen, and what to try."""


class BathbotError(Exception):
    """Base of every error that bathbot raises on purpose; each package derives one base from it."""


class DepthcorrError(BathbotError):
    """Base of this package's errors."""


class SettingsError(DepthcorrError):
    """A parameter outside its meaning."""
