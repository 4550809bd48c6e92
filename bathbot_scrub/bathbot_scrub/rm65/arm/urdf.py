"""A URDF of the RM65 with its scrub head, written from the table that the kinematics use.

    python -m bathbot_scrub.rm65.arm.urdf 6F > rm65_6f.urdf

Frames of links are those of the Denavit-Hartenberg table, so base_link..Link6 are where `Kinematics` puts
them. Masses are the manufacturer's; everything else about mass is our estimate: each link as a solid
cylinder of the size of its capsule. Shapes are cylinders with a sphere at each end: the capsules of
`capsules`, marked as such for readers that know capsules.
"""

import sys
from itertools import groupby
from math import asin, atan2, pi

import numpy as np
from bathbot_localize.arm.arm_shape import ArmCapsule
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import ArmSettingsError
from bathbot_scrub.rm65.arm.capsules import arm_shape
from bathbot_scrub.rm65.arm.kinematics import JOINT_NAMES, LINK_NAMES, Kinematics
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS

_MASSES = (1.51, 1.653, 0.726, 0.671, 0.647)  # [kg] Link1..Link5, data sheet
_FLANGE_MASSES = {"B": 0.107, "6F": 0.248, "6FB": 0.189}  # [kg] Link6, data sheet
_EFFORTS = (60, 60, 30, 10, 10, 10)  # [N m] of the joints


def moving_mass(variant: str) -> float:
    """Mass [kg] of the links that move, without the scrub head."""
    return sum(_MASSES) + _FLANGE_MASSES[variant]


def urdf(variant: str = "6F", head: ScrubHead = SCRUB_HEAD) -> str:
    """The description of a variant with a scrub head.

    Raises:
        ArmSettingsError: Unknown variant.
    """
    at_zero = Kinematics(variant).link_frames(np.zeros(6))
    capsules = arm_shape(variant, head).capsules
    shapes = {link: list(group) for link, group in groupby(capsules, lambda capsule: capsule.link)}
    masses = dict(zip(LINK_NAMES[1:], (*_MASSES, _FLANGE_MASSES[variant]), strict=True))
    masses[head.frame] = head.mass
    parts = [f'<robot name="rm65_{variant.lower()}">']
    parts += [_link(name, shapes[name], masses.get(name)) for name in (*LINK_NAMES, head.frame)]
    for index, name in enumerate(JOINT_NAMES):
        step = np.linalg.solve(at_zero[index], at_zero[index + 1])
        parts.append(_revolute(name, index, step))
    parts.append(
        f'  <joint name="{head.frame}_joint" type="fixed">\n'
        f'    <parent link="{LINK_NAMES[-1]}"/>\n    <child link="{head.frame}"/>\n'
        f"    {_origin((0.0, 0.0, head.length))}\n  </joint>"
    )
    return "\n".join([*parts, "</robot>", ""])


def _revolute(name: str, index: int, step: NDArray[np.float64]) -> str:
    """A joint whose child is at `step`, (4, 4), at angle zero."""
    low, high, speed = (bounds[index] for bounds in (RM65_LIMITS.lower, RM65_LIMITS.upper, RM65_LIMITS.speed))
    effort = _EFFORTS[index]
    return (
        f'  <joint name="{name}" type="revolute">\n'
        f'    <parent link="{LINK_NAMES[index]}"/>\n    <child link="{LINK_NAMES[index + 1]}"/>\n'
        f'    {_origin(step[:3, 3], _roll_pitch_yaw(step[:3, :3]))}\n    <axis xyz="0 0 1"/>\n'
        f'    <limit lower="{low:.9g}" upper="{high:.9g}" velocity="{speed:.9g}" effort="{effort}"/>\n'
        "  </joint>"
    )


def _link(name: str, capsules: list[ArmCapsule], mass: float | None) -> str:
    """A link; without a mass (the base, which stands still) it has no inertia."""
    lines = [f'  <link name="{name}">']
    if mass is not None:
        lines.append(_inertial(capsules[0], mass))
    marks = []
    for count, capsule in enumerate(capsules):
        start, end = np.array(capsule.start), np.array(capsule.end)
        length, turn = np.linalg.norm(end - start), _along(end - start)
        shapes = [((start + end) / 2, turn, f'<cylinder radius="{capsule.radius}" length="{length:.9g}"/>')]
        shapes += [(at, (0.0, 0.0, 0.0), f'<sphere radius="{capsule.radius}"/>') for at in (start, end)]
        for kind, (at, rpy, shape) in zip(("capsule", "start", "end"), shapes, strict=True):
            body = f"{_origin(at, rpy)}<geometry>{shape}</geometry>"
            lines.append(f'    <collision name="{name}_{kind}_{count}">{body}</collision>')
            lines.append(f"    <visual>{body}</visual>")
        marks.append(f'<capsule name="{name}_capsule_{count}"/>')
    lines.append(f"    <collision_checking>{''.join(marks)}</collision_checking>")
    return "\n".join([*lines, "  </link>"])


def _inertial(capsule: ArmCapsule, mass: float) -> str:
    """A solid cylinder along the capsule, as long as both together."""
    start, end = np.array(capsule.start), np.array(capsule.end)
    length = float(np.linalg.norm(end - start)) + 2.0 * capsule.radius
    across = mass * (3.0 * capsule.radius**2 + length**2) / 12.0
    along = 0.5 * mass * capsule.radius**2
    return (
        f'    <inertial>{_origin((start + end) / 2, _along(end - start))}<mass value="{mass}"/>'
        f'<inertia ixx="{across:.6g}" iyy="{across:.6g}" izz="{along:.6g}" ixy="0" ixz="0" iyz="0"/>'
        "</inertial>"
    )


def _origin(xyz: ArrayLike, rpy: ArrayLike = (0.0, 0.0, 0.0)) -> str:
    place, turn = (" ".join(repr(round(float(v), 12) + 0.0) for v in values) for values in (xyz, rpy))
    return f'<origin xyz="{place}" rpy="{turn}"/>'


def _along(direction: NDArray[np.float64]) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] that turn z along a direction, shape (3,)."""
    x, y, z = direction / np.linalg.norm(direction)
    return (0.0, atan2(np.hypot(x, y), z), atan2(y, x) if np.hypot(x, y) > 0.0 else 0.0)


def _roll_pitch_yaw(rotation: NDArray[np.float64]) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] of a rotation, shape (3, 3): R = Rz(yaw) Ry(pitch) Rx(roll)."""
    sine = -rotation[2, 0]
    if abs(sine) > 1.0 - 1e-12:  # yaw and roll turn about one axis
        return (atan2(-rotation[1, 2], rotation[1, 1]), np.sign(sine) * pi / 2, 0.0)
    return (atan2(rotation[2, 1], rotation[2, 2]), asin(sine), atan2(rotation[1, 0], rotation[0, 0]))


def main() -> None:
    """Print the URDF of the variant named on the command line, 6F if none."""
    try:
        sys.stdout.write(urdf(*sys.argv[1:2]))
    except ArmSettingsError as error:
        print(error, file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
