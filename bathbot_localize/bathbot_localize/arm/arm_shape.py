"""The shape of the RM65-6F with its scrub head, as capsules in the frames of its links.

Frames are those of the modified DH table (Craig): frame i sits at joint i, its z is the axis of
that joint, and T_(i-1)_i = Rx(alpha) Tx(a) Rz(q + offset) Tz(d). So Link2 has the upper arm
(256 mm) along its +x, Link4 has its origin at the wrist centre and the forearm (210 mm) behind it
along -z, Link6 is the flange with the wrist (172.5 mm) behind it along -z, and scrub_head has its
origin at the tip of the bristles, 0.10 m beyond the flange, with z into the skin.

Lengths are the manufacturer's; radii are taken from outline drawings, about 5 mm on the wide side.
Capsules end in half spheres, so neighbours overlap and a joint leaves no gap.
"""

from dataclasses import dataclass

HEAD_LENGTH = 0.10  # [m] from the flange to the tip of the bristles, d of Eq. (16)
BRUSH_RADIUS = 0.025  # [m]


@dataclass(frozen=True, slots=True)
class ArmCapsule:
    """All points within `radius` [m] of the segment from `start` to `end` [m], in the frame `link`."""

    link: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float


RM65_CAPSULES = (
    ArmCapsule("base_link", (0.0, 0.0, 0.0), (0.0, 0.0, 0.17), 0.055),
    ArmCapsule("Link1", (0.0, 0.0, -0.07), (0.0, 0.0, 0.0), 0.055),
    ArmCapsule("Link2", (0.0, 0.0, 0.0), (0.256, 0.0, 0.0), 0.050),
    ArmCapsule("Link3", (0.0, 0.0, 0.0), (0.0, -0.07, 0.0), 0.045),
    ArmCapsule("Link4", (0.0, 0.0, -0.14), (0.0, 0.0, 0.0), 0.040),
    ArmCapsule("Link5", (0.0, 0.0, 0.0), (0.0, -0.0725, 0.0), 0.040),
    ArmCapsule("Link6", (0.0, 0.0, -0.10), (0.0, 0.0, -0.01), 0.035),
    # The handle, then the brush: its sphere ends at the tip of the uncompressed bristles.
    ArmCapsule("scrub_head", (0.0, 0.0, -HEAD_LENGTH), (0.0, 0.0, -0.040), 0.020),
    ArmCapsule("scrub_head", (0.0, 0.0, -0.040), (0.0, 0.0, -BRUSH_RADIUS), BRUSH_RADIUS),
)
