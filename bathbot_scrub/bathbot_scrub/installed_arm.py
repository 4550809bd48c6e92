"""The arm that is installed: the one place that names it.

Whoever plans, masks or reports asks here and gets an `Arm`; another arm is another folder beside `rm65` and
another import here.
"""

from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS
from bathbot_scrub.rm65.arm.rm65 import RM65


def installed_arm(variant: str = "6F") -> RM65:
    """The arm in one of its variants.

    Raises:
        ArmSettingsError: Unknown variant.
    """
    return RM65(variant)


def descriptions() -> frozenset[str]:
    """The URDF of each variant, as the driver publishes it."""
    return frozenset(RM65(variant).description() for variant in FLANGE_OFFSETS)
