"""Plausible seated poses: rotations per bone of the Anny model, and arms that reach where a hand rests."""

import numpy as np

ARM_STYLES = ("hanging", "abducted", "thigh", "forward")


def rotation(axis: str, degrees: float) -> np.ndarray:
    """Rotation by an angle [deg] about a world axis, as Anny's `local-ref` poses want it, shape (4, 4)."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    matrix = np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    return matrix


def batch_rotation(axis: str, degrees: np.ndarray) -> np.ndarray:
    """The same for many angles, shape (N,) -> (N, 3, 3)."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    matrix = np.tile(np.eye(3), (len(degrees), 1, 1))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix[:, i, i], matrix[:, j, j], matrix[:, i, j], matrix[:, j, i] = c, c, -s, s
    return matrix


def hand_target(rng: np.random.Generator, style: str, joints: dict[str, np.ndarray], side: str) -> np.ndarray:
    """Draw where a palm lies [m, Anny's axes]: beside the seat, at the hip, on the thigh or held out."""
    sign = 1 if side == "L" else -1
    hip, knee, shoulder = (joints[f"{name}.{side}"] for name in ("upperleg01", "lowerleg01", "upperarm01"))
    if style == "hanging":
        return np.add(
            hip, (sign * rng.uniform(0.13, 0.19), rng.uniform(-0.1, 0.05), rng.uniform(-0.12, 0.02))
        )
    if style == "abducted":
        return np.add(
            hip, (sign * rng.uniform(0.17, 0.27), rng.uniform(-0.32, -0.12), rng.uniform(0.08, 0.2))
        )
    if style == "thigh":
        return (
            hip
            + rng.uniform(0.6, 1.0) * (knee - hip)
            + (sign * rng.uniform(-0.02, 0.05), 0.0, rng.uniform(0.08, 0.1))
        )
    return np.add(
        shoulder, (sign * rng.uniform(-0.1, 0.12), rng.uniform(-0.5, -0.38), rng.uniform(-0.3, -0.08))
    )


def arm_rotations(angles: np.ndarray, sign: int) -> tuple[np.ndarray, np.ndarray]:
    """Rotations of upper arm and forearm (N, 3, 3), of lowering, flexion, turn, elbow [deg] (N, 4)."""
    lower, flex, turn, elbow = angles.T
    upper = batch_rotation("x", -flex) @ batch_rotation("y", sign * lower) @ batch_rotation("z", sign * turn)
    return upper, batch_rotation("x", -elbow)


def reach(
    rng: np.random.Generator,
    target: np.ndarray,
    rest: np.ndarray,
    shoulder: np.ndarray,
    parent: np.ndarray,
    sign: int,
) -> np.ndarray:
    """Arm angles [deg] that bring the palm near a target.

    Args:
        rng: For the search.
        target: Where the palm goes [m], shape (3,).
        rest: Shoulder, elbow, wrist at rest [m], shape (3, 3).
        shoulder: The shoulder as the trunk carries it [m], shape (3,).
        parent: Rotation of the trunk at the shoulder, shape (3, 3).
        sign: +1 for the left arm, -1 for the right.
    """
    angles = rng.uniform((4, -20, -35, -12), (40, 75, 45, 95), size=(6000, 4))
    upper, fore = arm_rotations(angles, sign)
    upper = parent @ upper
    palm = 1.35 * (rest[2] - rest[1])
    hands = shoulder + upper @ (rest[1] - rest[0]) + (upper @ fore) @ palm
    effort = 1e-7 * ((angles - (25, 15, 0, 30)) ** 2).sum(axis=1)
    return angles[np.argmin(((hands - target) ** 2).sum(axis=1) + effort)]


def pose(rng: np.random.Generator, legs: str) -> dict[str, np.ndarray]:
    """Draw a seated pose without its arms: a rotation per bone about the world axes at rest."""
    bones = {}
    lean = rng.uniform(-8, 10) / 4
    for spine in ("spine04", "spine03", "spine02", "spine01"):
        bones[spine] = rotation("x", -lean + rng.normal(0, 1.0)) @ rotation("y", rng.normal(0, 1.0))
    bones["head"] = rotation("z", rng.uniform(-25, 25)) @ rotation("x", rng.uniform(-6, 14))
    bones["neck02"] = rotation("z", rng.uniform(-12, 12)) @ rotation("y", rng.normal(0, 4))
    hip_range, knee_range = {"stool": ((78, 90), (74, 98)), "footrest": ((90, 100), (88, 105)),
                             "stretched": ((74, 86), (32, 58))}[legs]  # fmt: skip
    hip, knee = rng.uniform(*hip_range), rng.uniform(*knee_range)
    for side, sign in (("L", 1), ("R", -1)):
        bones[f"wrist.{side}"] = rotation("x", rng.uniform(-15, 15))
        hip_side, knee_side = hip + rng.normal(0, 3), knee + rng.normal(0, 5)
        spread = sign * rng.uniform(0, 10)
        bones[f"upperleg01.{side}"] = rotation("z", spread) @ rotation("x", -hip_side)
        bones[f"lowerleg01.{side}"] = rotation("x", knee_side)
        bones[f"foot.{side}"] = rotation("x", float(np.clip(hip_side - knee_side, -30, 30)))
        for finger in range(2, 6):
            curl = rng.uniform(2, 18)
            for joint in (1, 2, 3):
                bones[f"finger{finger}-{joint}.{side}"] = rotation("y", -sign * curl) @ rotation(
                    "x", -0.5 * curl
                )
    return bones
