"""The shape of the RM65 with its scrub head: its links as capsules, and where it can work.

Frames are those of the modified DH table (Craig): frame i sits at joint i, its z is the axis of that joint.
So Link2 has the upper arm along its +x, Link4 has its origin at the wrist centre and the forearm behind it
along -z, Link6 is the flange with the wrist behind it along -z.

Lengths are the manufacturer's; radii are taken from outline drawings, about 5 mm on the wide side.
"""

from bathbot_localize.arm.arm_shape import ArmCapsule, ArmShape
from bathbot_localize.arm.scrub_head import ScrubHead
from bathbot_localize.surface.workspace import Workspace

from bathbot_scrub.rm65.arm.kinematics import BASE_HEIGHT, FLANGE_OFFSETS, LINK_NAMES, UPPER_ARM

_WRIST = 0.0725  # [m] of the flange's part that is not the wrist's


def arm_shape(variant: str, head: ScrubHead) -> ArmShape:
    """Links and scrub head of a variant; the others have a shorter flange than the 6F."""
    behind = FLANGE_OFFSETS[variant]  # from the flange to the wrist's centre
    links = (
        ArmCapsule("base_link", (0.0, 0.0, 0.0), (0.0, 0.0, 0.17), 0.055),
        ArmCapsule("Link1", (0.0, 0.0, -0.07), (0.0, 0.0, 0.0), 0.055),
        ArmCapsule("Link2", (0.0, 0.0, 0.0), (UPPER_ARM, 0.0, 0.0), 0.050),
        ArmCapsule("Link3", (0.0, 0.0, 0.0), (0.0, -0.07, 0.0), 0.045),
        ArmCapsule("Link4", (0.0, 0.0, -0.14), (0.0, 0.0, 0.0), 0.040),
        ArmCapsule("Link5", (0.0, 0.0, 0.0), (0.0, -0.0725, 0.0), 0.040),
        ArmCapsule("Link6", (0.0, 0.0, _WRIST - behind), (0.0, 0.0, -0.01), 0.035),
    )
    workspace = Workspace(
        shoulder=(0.0, 0.0, BASE_HEIGHT),
        nearest=0.22,
        farthest=0.42,
        behind=behind + head.length,
        within=0.85,
    )
    return ArmShape((*links, *head.capsules), LINK_NAMES[-1], ("base_link", "Link1"), workspace)
