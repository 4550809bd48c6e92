"""Skin, hair and garments painted on a body: reflectance per vertex and what is no longer skin.

The tones are sRGB samples of Fitzpatrick types I-VI; a real number between them is interpolated.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.body import Body, Mark, Part, Side, smoothed, vertex_normals
from bathbot_bringup.sim.render.mesh import Mesh

Array = NDArray[np.float64]

FITZPATRICK = np.array([
    (246, 214, 196), (236, 194, 166), (214, 164, 128), (176, 124, 86), (122, 80, 54), (72, 47, 36),
]) / 255.0  # fmt: skip


@dataclass(frozen=True, slots=True)
class Look:
    """How a person looks and what they wear.

    Attributes:
        tone: Fitzpatrick type, 1..6, real.
        redness: 0..1, of cheeks, knees, hands and feet.
        mottling: Contrast of blotches, 0..1.
        hair: Linear colour of the hair.
        hair_depth: How far the hair stands off the scalp [m].
        shorts: How far the shorts reach from hip to knee, 0..1.
        waist: How far they reach from pelvis to neck, 0..1.
        top: Band of the trunk a top covers, from and to, 0..1; equal for none.
        cloth: Linear colour of the garments.
        wetness: 0 dry .. 1 dripping.
    """

    tone: float
    redness: float = 0.3
    mottling: float = 0.3
    hair: tuple[float, float, float] = (0.02, 0.015, 0.01)
    hair_depth: float = 0.012
    shorts: float = 0.45
    waist: float = 0.14
    top: tuple[float, float] = (0.0, 0.0)
    cloth: tuple[float, float, float] = (0.05, 0.1, 0.3)
    wetness: float = 0.2


def linear(srgb: ArrayLike) -> Array:
    """From sRGB 0..1 to linear reflectance."""
    srgb = np.asarray(srgb, dtype=float)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def tone_colour(tone: float) -> Array:
    """Linear reflectance of a Fitzpatrick type 1..6, shape (3,)."""
    return np.array([np.interp(tone, np.arange(1, 7), channel) for channel in linear(FITZPATRICK).T])


def blotches(points: Array, rng: np.random.Generator, size: float) -> Array:
    """Smooth noise of unit spread over points [m], shape (N, 3) -> (N,), in blotches of one size [m]."""
    waves = rng.normal(size=(12, 3)) / size
    return np.sqrt(2.0 / 12) * np.sin(points @ waves.T + rng.uniform(0, 2 * np.pi, 12)).sum(axis=1)


def garment_mask(body: Body, look: Look) -> NDArray[np.bool_]:
    """Vertices under shorts or top, shape (V,)."""
    leg = (body.parts == Part.LOWER_LIMB) & (body.fraction < look.shorts)
    trunk = body.parts == Part.TRUNK
    top = trunk & (body.fraction > look.top[0]) & (body.fraction < look.top[1])
    return leg | top | (trunk & (body.fraction < look.waist))


def skin_albedo(body: Body, look: Look, rng: np.random.Generator) -> Array:
    """Linear reflectance of bare skin, shape (V, 3)."""
    albedo = np.tile(tone_colour(look.tone), (len(body.parts), 1))
    light = np.clip((6.0 - look.tone) / 5.0, 0.15, 1.0)
    blush = 0.25 * blotches(body.rest, rng, 0.04) + 0.15 * blotches(body.rest, rng, 0.012)
    extremity = smoothed(np.isin(body.parts, (Part.HAND, Part.FOOT)).astype(float), body.faces, 4)
    knee = np.exp(-(((body.fraction - 1.0) / 0.15) ** 2)) * (body.parts == Part.LOWER_LIMB)
    face = (body.parts == Part.FACE) * (0.5 + 0.5 * blotches(body.rest, rng, 0.03))
    red = light * look.redness * (0.25 * extremity + 0.25 * knee + 0.3 * face + 0.3 * look.mottling * blush)
    albedo *= 1.0 + red[:, None] * (0.25, -0.35, -0.35)
    albedo *= 1.0 + 0.12 * look.mottling * blotches(body.rest, rng, 0.08)[:, None]
    albedo[body.marks == Mark.LIPS] *= (0.8, 0.5, 0.5)
    albedo[body.marks == Mark.NIPPLE] *= (0.65, 0.45, 0.42)
    albedo[body.marks == Mark.BROW] *= 0.35
    return np.clip(albedo, 0.005, 0.95)


def paint_eyes(body: Body, albedo: Array, rng: np.random.Generator) -> None:
    """White balls with a dark iris, looking ahead."""
    iris = np.array([(0.03, 0.02, 0.01), (0.05, 0.1, 0.16), (0.08, 0.05, 0.02)])[
        rng.choice(3, p=[0.6, 0.2, 0.2])
    ]
    for sign in (-1, 1):
        ball = np.flatnonzero((body.marks == Mark.EYE) & (np.sign(body.rest[:, 1]) == sign))
        if not len(ball):
            continue
        front = body.rest[ball[np.argmax(body.rest[ball, 0])]]
        off = np.linalg.norm(body.rest[ball] - front, axis=1)
        albedo[ball] = np.where(off[:, None] < 0.0065, iris, 0.55)


def dressed(body: Body, look: Look, rng: np.random.Generator) -> Mesh:
    """A body with skin, hair and garments, in the body frame."""
    albedo = skin_albedo(body, look, rng)
    paint_eyes(body, albedo, rng)
    normals = vertex_normals(body.vertices, body.faces)
    hair = smoothed((body.marks == Mark.SCALP).astype(float), body.faces, 3)
    cloth = garment_mask(body, look)
    cover = smoothed(cloth.astype(float), body.faces, 1)
    folds = 0.5 + 0.5 * np.sin(blotches(body.rest, rng, 0.02) * 2.0)
    lift = hair**0.5 * look.hair_depth * (0.8 + 0.2 * folds) + cover * (0.003 + 0.005 * folds)
    strands = 1.0 + 0.35 * blotches(body.rest, rng, 0.004)[:, None]
    albedo = np.where(
        (body.marks == Mark.SCALP)[:, None], np.array(look.hair) * np.clip(strands, 0.3, 2), albedo
    )
    albedo = np.where(cloth[:, None], np.array(look.cloth) * (0.75 + 0.35 * folds)[:, None], albedo)
    bare = ~cloth & (body.marks != Mark.SCALP) & (body.marks != Mark.EYE)
    labels = np.where(bare, body.parts, Part.NOT_SKIN).astype(np.uint8)
    sides = np.where(bare, body.sides, Side.MIDDLE).astype(np.uint8)
    return Mesh(
        vertices=body.vertices + lift[:, None] * normals,
        faces=body.faces,
        albedo=albedo,
        gloss=np.where(bare, 0.12 + 0.9 * look.wetness, np.where(body.marks == Mark.EYE, 1.0, 0.05)),
        texture=body.rest,
        grain=np.where(bare, 0.05 + 0.05 * look.mottling, 0.25),
        labels=face_votes(3 * labels + sides, body.faces) // 3,
        sides=face_votes(3 * labels + sides, body.faces) % 3,
    )


def face_votes(labels: NDArray[np.uint8], faces: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Label of a triangle: that of two of its corners, else of the first."""
    a, b, c = labels[faces].T
    return np.where(b == c, b, a)


def random_look(rng: np.random.Generator, male: bool, wetness: float | None = None) -> Look:
    """Draw how somebody looks; women wear a top."""
    hairs = (
        (0.012, 0.010, 0.009),
        (0.03, 0.018, 0.010),
        (0.10, 0.055, 0.025),
        (0.25, 0.23, 0.21),
        (0.35, 0.22, 0.10),
    )
    cloths = ((0.02, 0.03, 0.08), (0.03, 0.03, 0.03), (0.35, 0.03, 0.04), (0.5, 0.5, 0.5), (0.05, 0.2, 0.12),
              (0.45, 0.35, 0.05), (0.1, 0.3, 0.5), (0.3, 0.05, 0.25))  # fmt: skip
    bottom = rng.uniform(0.44, 0.5)
    look = Look(
        tone=float(rng.uniform(1.0, 6.0)),
        redness=float(rng.uniform(0.0, 0.8)),
        mottling=float(rng.uniform(0.1, 0.8)),
        hair=hairs[rng.integers(len(hairs))],
        hair_depth=float(rng.uniform(0.004, 0.02)),
        shorts=float(rng.choice([0.36, 0.42, 0.5, 0.65]) + rng.uniform(-0.04, 0.04)),
        waist=float(rng.uniform(0.15, 0.24)),
        top=(0.0, 0.0) if male else (bottom, bottom + rng.uniform(0.24, 0.3)),
        cloth=cloths[rng.integers(len(cloths))],
        wetness=float(rng.beta(1.2, 2.0)) if wetness is None else wetness,
    )
    if rng.uniform() < 0.12:  # a bathing cap or a towel round the head
        return replace(
            look, hair=cloths[rng.integers(len(cloths))], hair_depth=float(rng.uniform(0.01, 0.035))
        )
    return look
