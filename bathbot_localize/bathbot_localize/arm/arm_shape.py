"""The shape of an arm with its scrub head, as the localiser needs it: capsules in the frames of its links.

Capsules end in half spheres, so neighbours overlap and a joint leaves no gap. Where the links are comes from
TF; which arm it is, from `installed_shape`.
"""

from dataclasses import dataclass
from importlib import import_module

from bathbot_localize.errors import LocalizeError
from bathbot_localize.surface.workspace import Workspace

INSTALLED_ARM = "bathbot_scrub.installed_arm"
"""The module that knows the arm. It lies downstream, so it is found by name, when a node starts."""


class UnknownArmError(LocalizeError):
    """No module tells what the arm looks like."""


@dataclass(frozen=True, slots=True)
class ArmCapsule:
    """All points within `radius` [m] of the segment from `start` to `end` [m], in the frame `link`."""

    link: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float


@dataclass(frozen=True, slots=True)
class ArmShape:
    """What an arm fills, and where it can work.

    Attributes:
        capsules: Of all links and the scrub head, from the base outwards.
        flange: Frame that the scrub head, or a marker in its place, is fixed to.
        standing: Links that stand still or turn about their own axis at most, and so come near nobody.
        workspace: Where skin can be touched.
    """

    capsules: tuple[ArmCapsule, ...]
    flange: str
    standing: tuple[str, ...]
    workspace: Workspace

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the frames that have a capsule, from the base outwards."""
        return tuple(dict.fromkeys(capsule.link for capsule in self.capsules))

    @property
    def moving(self) -> tuple[ArmCapsule, ...]:
        """Capsules of the links that can come near a person."""
        return tuple(capsule for capsule in self.capsules if capsule.link not in self.standing)


def installed_shape() -> ArmShape:
    """The shape of the arm that is installed.

    Raises:
        UnknownArmError: The package that knows the arm is not there.
    """
    try:
        return import_module(INSTALLED_ARM).installed_arm().shape
    except ImportError as error:
        raise UnknownArmError(
            f"{INSTALLED_ARM} does not tell the arm's shape ({error}); build and install bathbot_scrub too"
        ) from error
