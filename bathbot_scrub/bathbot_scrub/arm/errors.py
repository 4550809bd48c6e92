"""Why the arm does not do what it was asked. Every message says what is wrong and what to try."""

from bathbot_scrub.errors import ScrubError


class ArmError(ScrubError):
    """Base of the errors of the arm."""


class ArmSettingsError(ArmError):
    """A parameter or a limits file outside its meaning."""


class InvalidPoseError(ArmError):
    """A pose that is not finite, not a rigid transform, or in the wrong frame."""


class UnreachableError(ArmError):
    """A pose or path without joint solution inside the limits.

    Attributes:
        index: First pose of the path without solution.
    """

    def __init__(self, message: str, index: int = 0) -> None:
        """Keep the index of the first pose without solution."""
        self.index = index
        super().__init__(message)


class JointLimitError(ArmError):
    """A joint angle or step outside the limits.

    Attributes:
        joint: Number of the joint, 1 to 6.
        value: Angle or speed asked for [rad] or [rad/s].
        limit: Nearest limit, same unit.
    """

    def __init__(self, what: str, joint: int, value: float, limit: float) -> None:
        """Keep the joint (1..6), the value and the nearest limit."""
        self.joint, self.value, self.limit = joint, value, limit
        super().__init__(
            f"joint {joint}: {what} {value:.4f} is beyond the limit {limit:.4f}; choose a nearer target"
        )


class ProtocolError(ArmError):
    """Bytes that are no frame of the controller's protocol, or a reply without its fields."""


class ArmConnectionError(ArmError):
    """No connection to the controller, or no answer in time."""


class RefusedError(ArmError):
    """The controller answered that it will not do it."""


class NotReadyError(ArmError):
    """The arm is in a state in which this must not be done."""


class NoContactError(ArmError):
    """Nothing felt where the skin should be."""


class ForceLimitError(ArmError):
    """The arm left the skin because the force passed the threshold."""


class CanceledError(ArmError):
    """Someone asked to stop before the motion was done."""


class CollisionError(UnreachableError):
    """A path on which a link would meet the arm itself, a wall or the body.

    Attributes:
        link: Name of the link.
        other: What it would meet, and where.
        distance: How near it would come [m]; negative: how deep.
        allowed: The least distance allowed [m].
    """

    def __init__(self, link: str, other: str, distance: float, allowed: float) -> None:
        """Keep the evidence."""
        self.link, self.other, self.distance, self.allowed = link, other, distance, allowed
        how = f"come within {1e3 * distance:.0f} mm of" if distance > 0.0 else "run into"
        super().__init__(f"{link} would {how} {other}, the least allowed is {1e3 * allowed:.0f} mm")
