"""What bathing does to a picture: steam, drops on the lens, exposure, noise, and things in the way."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.body import Part
from bathbot_bringup.sim.render.render import Rendering, developed


class Weather(NamedTuple):
    """What lies between the scene and a file.

    Attributes:
        steam: Optical thickness of the fog at one metre; 0 none, 1.2 dense.
        drops: Number of drops on the lens.
        exposure: Factor on the light.
        tint: White balance error, factors on red, green and blue.
        noise: Sensor noise, share of full scale at mid grey.
        blur: Lens and motion blur [px].
        occluders: Number of flat things in front of the camera.
    """

    steam: float = 0.0
    drops: int = 0
    exposure: float = 1.0
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    noise: float = 0.01
    blur: float = 0.5
    occluders: int = 0


def clouds(rng: np.random.Generator, shape: tuple[int, int]) -> NDArray[np.float32]:
    """Smooth noise 0..1 of a picture's shape."""
    field = np.zeros(shape, dtype=np.float32)
    for cells, weight in ((3, 1.0), (7, 0.5), (17, 0.25)):
        coarse = rng.normal(size=(cells, cells)).astype(np.float32)
        field += weight * cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC)
    return (field - field.min()) / max(float(np.ptp(field)), 1e-6)


def steamed(radiance: NDArray, depth: NDArray, thickness: float, rng: np.random.Generator) -> NDArray:
    """Light after fog of an optical thickness per metre."""
    density = thickness * (0.4 + 1.2 * clouds(rng, depth.shape))
    passing = np.exp(-density * np.minimum(depth, 3.0))[..., None]
    glow = np.float32(np.clip(radiance.mean(), 0.15, 0.7) * rng.uniform(1.0, 1.5))
    return radiance * passing + glow * (1.0 - passing)


def dropped(radiance: NDArray, count: int, rng: np.random.Generator) -> NDArray:
    """Light through a lens with water drops: each shows the scene upside down, small and blurred."""
    height, width = radiance.shape[:2]
    result = radiance.copy()
    soft = cv2.GaussianBlur(radiance, (0, 0), 6.0)
    v, u = np.mgrid[:height, :width].astype(np.float32)
    for _ in range(count):
        x, y, radius = rng.uniform(0, width), rng.uniform(0, height), rng.uniform(5, 26)
        off = np.hypot((u - x) / rng.uniform(0.8, 1.2), v - y) / radius
        inside = np.clip((1.0 - off) * 4.0, 0.0, 1.0)[..., None]
        flipped = cv2.remap(
            soft, np.clip(x - 3 * (u - x), 0, width - 1), np.clip(y - 3 * (v - y), 0, height - 1), 1
        )
        rim = 1.0 - 0.35 * np.clip(1.0 - 6.0 * np.abs(off - 0.85), 0.0, 1.0)[..., None]
        result = result * (1.0 - 0.85 * inside) + 0.85 * inside * flipped * rim
    return result


def hide(rendering: Rendering, rng: np.random.Generator) -> Rendering:
    """Put a flat grey or coloured thing in front of part of the picture; what it hides is no longer skin."""
    height, width = rendering.parts.shape
    size = rng.uniform(0.08, 0.3, 2) * (width, height)
    centre = rng.uniform(0.0, 1.0, 2) * (width, height)
    corners = cv2.boxPoints((tuple(centre), tuple(size), float(rng.uniform(0, 90)))).astype(np.int32)
    mask = np.zeros(rendering.parts.shape, dtype=np.uint8)
    cv2.fillPoly(mask, [corners], 1)
    radiance, parts = rendering.radiance.copy(), rendering.parts.copy()
    grey = rng.uniform(0.03, 0.6) * (1.0 + rng.normal(0, 0.12, 3) * (rng.uniform() < 0.5))
    radiance[mask > 0] = np.clip(grey * rng.uniform(0.8, 1.0), 0.01, 1.0)
    parts[mask > 0] = Part.NOT_SKIN
    return rendering._replace(radiance=radiance, parts=parts)


def weathered(rendering: Rendering, weather: Weather, rng: np.random.Generator) -> Rendering:
    """The same view through bathroom air and a real lens; labels follow only what hides the scene."""
    for _ in range(weather.occluders):
        rendering = hide(rendering, rng)
    light = rendering.radiance
    if weather.steam > 0.0:
        light = steamed(light, rendering.depth, weather.steam, rng)
    if weather.drops:
        light = dropped(light, weather.drops, rng)
    if weather.blur > 0.0:
        light = cv2.GaussianBlur(light, (0, 0), weather.blur)
    light = light * np.array(weather.tint, dtype=np.float32) * np.float32(weather.exposure)
    spread = weather.noise * np.sqrt(np.clip(light, 0.0, 1.0) * 0.5 + 0.02)
    light = light + spread * rng.standard_normal(light.shape, dtype=np.float32)
    return rendering._replace(colour=developed(light), radiance=light)
