"""Errors a user can mend. Every message says what is wrong, the value seen, and what to try."""

from bathbot_depthcorr.errors import BathbotError


class ScrubError(BathbotError):
    """Base of this package's errors."""


class SettingsError(ScrubError):
    """A parameter outside its meaning."""


class SurfaceError(ScrubError):
    """No usable skin surface around the target."""


class TargetLostError(ScrubError):
    """The skin was not seen any more, or moved too far, while it was being scrubbed."""


class OutOfReachError(ScrubError):
    """Too little of the patch lies within the arm's reach."""

    def __init__(self, reached: float, wanted: float, reason: str) -> None:
        """Keep the evidence: the share of the path within reach and the share asked for, 0..1."""
        self.reached, self.wanted = reached, wanted
        super().__init__(
            f"only {reached:.0%} of the patch is within reach, at least {wanted:.0%} is needed "
            f"({reason}); move the chair closer to the arm or choose another region"
        )


class ArmStoppedError(ScrubError):
    """The arm stands still, or is silent, where it should scrub."""


class ArmLeftError(ScrubError):
    """The arm left the skin by itself: too much force."""


class NotReadyError(ScrubError):
    """Asked to scrub when it is not possible."""


class SegmentRefusedError(ScrubError):
    """The arm takes no more of the path."""


class ScrubCanceledError(ScrubError):
    """Someone asked to stop before the path was done."""
