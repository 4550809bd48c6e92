"""Errors of this package. Every message says what is wrong, the value seen, and what to try."""

from bathbot_depthcorr.errors import BathbotError


class LocalizeError(BathbotError):
    """Base of this package's errors."""


class SettingsError(LocalizeError):
    """A parameter outside its meaning."""
