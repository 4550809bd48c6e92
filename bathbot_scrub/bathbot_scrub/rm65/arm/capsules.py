"""The links of each RM65 variant as capsules: the shape that may not touch anything.

`bathbot_localize.arm.arm_shape` has the shape of the 6F, our own estimate from link lengths and outlines; the
camera's arm mask and the collision check share it. The other variants have a shorter flange.
"""

from dataclasses import replace

from bathbot_localize.arm.arm_shape import RM65_CAPSULES, ArmCapsule

from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS

_DRAWN = FLANGE_OFFSETS["6F"]


def arm_capsules(variant: str) -> tuple[ArmCapsule, ...]:
    """Capsules of all links and the scrub head, from the base outwards."""
    shorter = _DRAWN - FLANGE_OFFSETS[variant]
    return tuple(
        replace(capsule, start=(*capsule.start[:2], capsule.start[2] + shorter))
        if capsule.link == "Link6"
        else capsule
        for capsule in RM65_CAPSULES
    )
