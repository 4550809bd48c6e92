"""Render pictures of bathing people with PASCAL VOC boxes of visible skin, for training the skin detector.

    python render_skin_dataset.py --bodies BODIES.npz --first 0 --last 69 --count 700 --seed 1 --out DIR

Writes DIR/images/*.jpg and DIR/annotations/*.xml. A picture depends on the seed and its number only.
"""

import argparse
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
from bathbot_bringup.sim.body import Body, load_body
from bathbot_bringup.sim.render.bathroom import arm_like, clutter, random_lighting, random_room, stool
from bathbot_bringup.sim.render.boxes import skin_boxes, write_voc
from bathbot_bringup.sim.render.mesh import merged
from bathbot_bringup.sim.render.render import Rendering, render
from bathbot_bringup.sim.render.stage import lit_stage, looking_at
from bathbot_bringup.sim.render.weather import Weather, weathered
from bathbot_bringup.sim.skin_tone import dressed, random_look
from bathbot_depthcorr.geometry.pinhole import Pinhole

COLOUR_DISTORTION = (-0.0565, 0.0688, -0.00072, -0.00002, -0.0224)


def random_camera(rng: np.random.Generator) -> Pinhole:
    """A D455 colour stream, 640x480 or 640x400, with the spread between units."""
    if rng.uniform() < 0.5:
        focal = rng.uniform(370.0, 400.0)
        return Pinhole(640, 480, focal, focal, 319.5, 239.5, COLOUR_DISTORTION)
    focal = rng.uniform(308.0, 326.0)
    return Pinhole(640, 400, focal, focal, 319.5, 199.5, COLOUR_DISTORTION)


def random_view(rng: np.random.Generator, body: Body) -> np.ndarray:
    """Camera pose in the body frame: often as on the robot's mast, else anywhere around the person."""
    if rng.uniform() < 0.45:
        turn, rise, distance = rng.uniform(-65, 65), rng.uniform(12, 42), rng.uniform(0.7, 1.15)
        target = 0.5 * (body.landmarks["spine02"] + body.landmarks["upperleg01.L"]) * (1, 0, 1) + (0.12, 0, 0)
        target = target + rng.normal(0, 0.08, 3)
        roll = rng.normal(0, 3)
    else:
        turn = rng.uniform(-100, 100) if rng.uniform() < 0.85 else rng.uniform(100, 260)
        rise, distance = rng.uniform(-5, 48), rng.uniform(0.6, 1.6)
        names = (
            "head",
            "spine02",
            "spine02",
            "wrist.L",
            "wrist.R",
            "lowerleg01.L",
            "lowerleg01.R",
            "foot.L",
            "foot.R",
        )
        target = body.landmarks[names[rng.integers(len(names))]] + rng.normal(0, 0.12, 3)
        roll = rng.normal(0, 12) if rng.uniform() < 0.3 else rng.normal(0, 3)
    turn, rise = np.deg2rad([turn, rise])
    eye = target + distance * np.array(
        [np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)]
    )
    eye[2] = max(eye[2], body.vertices[:, 2].min() + 0.25)
    return looking_at(eye, target, np.deg2rad(roll))


def random_weather(rng: np.random.Generator) -> Weather:
    """Draw the air and the lens; a third of the pictures is clear."""
    return Weather(
        steam=float(rng.uniform(0.1, 1.0)) if rng.uniform() < 0.35 else 0.0,
        drops=int(rng.integers(1, 9)) if rng.uniform() < 0.2 else 0,
        exposure=float(np.exp(rng.normal(0.0, 0.3))),
        tint=tuple(1.0 + rng.normal(0.0, 0.06, 3)),
        noise=float(rng.uniform(0.003, 0.035)),
        blur=float(rng.uniform(0.4, 1.1)),
        occluders=int(rng.integers(1, 3)) if rng.uniform() < 0.15 else 0,
    )


def picture(rng: np.random.Generator, body: Body) -> Rendering:
    """One random picture of one person."""
    T_world_camera, pinhole = random_view(rng, body), random_camera(rng)
    eye = T_world_camera[:3, 3]
    floor = float(body.vertices[:, 2].min()) - float(rng.choice([0.0, 0.0, 0.05, 0.15]))
    around = np.stack([eye, body.vertices.min(axis=0), body.vertices.max(axis=0)])
    room = random_room(
        rng, (*(around[:, :2].min(axis=0) - 0.2), floor), (*(around[:, :2].max(axis=0) + 0.2), 2.0)
    )
    things = [*stool((0.0, 0.0, 0.0), floor, rng), *clutter(rng, room)]
    if rng.uniform() > 0.03:
        things.insert(0, dressed(body, random_look(rng, body.male), rng))
    if rng.uniform() < 0.3:
        tip = body.landmarks[("spine02", "wrist.L", "wrist.R", "lowerleg01.L")[rng.integers(4)]] + (
            0.15,
            0.0,
            0.05,
        )
        base = np.array([0.62, rng.uniform(-0.5, 0.5), rng.uniform(-0.1, 0.3)])
        if np.linalg.norm(base - eye) > 0.35 and np.linalg.norm(tip - eye) > 0.35:
            things += arm_like(rng, base, tip, floor)
    stage = lit_stage(merged(things), room, random_lighting(rng, room), rng, rays=12, samples=3)
    return weathered(render(stage, pinhole, T_world_camera), random_weather(rng), rng)


def write_picture(number: int, arguments: argparse.Namespace) -> int:
    """Render picture `number` and its boxes; returns the number of boxes."""
    rng = np.random.default_rng([arguments.seed, number])
    body = load_body(int(rng.integers(arguments.first, arguments.last + 1)), arguments.bodies)
    taken = picture(rng, body)
    name = f"{number:05d}"
    quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(75, 96))]
    cv2.imwrite(str(arguments.out / "images" / f"{name}.jpg"), taken.colour[..., ::-1], quality)
    boxes = skin_boxes(taken.parts, taken.sides)
    write_voc(arguments.out / "annotations" / f"{name}.xml", f"{name}.jpg", taken.parts.shape, boxes)
    return len(boxes)


def main() -> None:
    """Write the data set."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", type=Path, required=True)
    parser.add_argument("--first", type=int, default=0, help="first body of the file to use")
    parser.add_argument("--last", type=int, default=11, help="last body of the file to use")
    parser.add_argument("--start", type=int, default=0, help="number of the first picture")
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    for folder in ("images", "annotations"):
        (arguments.out / folder).mkdir(parents=True, exist_ok=True)
    numbers = range(arguments.start, arguments.start + arguments.count)
    with get_context("spawn").Pool(arguments.workers) as pool:
        boxes = pool.map(partial(write_picture, arguments=arguments), numbers, chunksize=8)
    print(f"{len(boxes)} pictures, {sum(boxes)} boxes in {arguments.out}")


if __name__ == "__main__":
    main()
