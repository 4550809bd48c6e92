"""What a body bears in a collision with a robot: the outer bound of every force limit and of every speed.

Numbers of ISO/TS 15066:2016, Table A.2 and A.3, read from two public transcriptions that agree, not from the
standard: onset of pain of healthy adults at work. They are no comfort, and old or frail skin is not covered.
A class of skin is several rows of the table; each bound is that of the row that bears least.
"""

from typing import NamedTuple


class BodyPart(NamedTuple):
    """One row of the table."""

    name: str
    quasi_static: float  # [N] that may clamp it
    stiffness: float  # [N/m]
    mass: float  # [kg] that moves with it


_FACE = BodyPart("face", 65.0, 75e3, 4.4)
_CHEST = BodyPart("chest", 140.0, 25e3, 40.0)
_ABDOMEN = BodyPart("abdomen", 110.0, 10e3, 40.0)
_BACK = BodyPart("back and shoulders", 210.0, 35e3, 40.0)
_UPPER_ARM = BodyPart("upper arm and elbow", 150.0, 30e3, 3.0)
_FOREARM = BodyPart("forearm and wrist", 160.0, 40e3, 2.0)
_HAND = BodyPart("hand and fingers", 140.0, 75e3, 0.6)
_THIGH = BodyPart("thigh and knee", 220.0, 50e3, 75.0)
_LOWER_LEG = BodyPart("lower leg", 130.0, 60e3, 75.0)

PARTS: dict[str, tuple[BodyPart, ...]] = {  # by class of skin
    "Face_skin": (_FACE,),
    "Trunk_skin": (_CHEST, _ABDOMEN, _BACK),
    "Upperlimb_skin": (_UPPER_ARM, _FOREARM),
    "Lowerlimb_skin": (_THIGH, _LOWER_LEG),
    "Hand_skin": (_HAND,),
    "Foot_skin": (_LOWER_LEG,),  # the table has no foot
}


def parts_of(region: str) -> tuple[BodyPart, ...]:
    """The rows that a class of skin may be; all of them where the class is unknown."""
    return PARTS.get(region) or tuple(part for parts in PARTS.values() for part in parts)


def quasi_static(region: str) -> float:
    """Largest force [N] that a class of skin may be clamped with; the least of all where it is unknown."""
    return min(part.quasi_static for part in parts_of(region))
