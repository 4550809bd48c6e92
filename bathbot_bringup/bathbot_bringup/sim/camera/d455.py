"""The D455's depth: from true distances to the 16-bit millimetres its topic carries.

    d = f B / ((1 + scale) Z) + e
    e = gL(u, v) - gR(u - d, v) + offset(T) + A sin(2 pi d) + frozen + temporal
    Z_out = f B / round(d)

gL and gR are the residual rectification of the two imagers. gR moves with the disparity, so that the error of
a pixel is no fixed function of its distance. On top: the blind left band, shadows left of foregrounds, flying
pixels at edges, a nearest distance, and what water does.
"""

from typing import NamedTuple

import cv2
import numba
import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.camera.d455_unit import BASELINE, SEARCH, Preset, make_unit

NATIVE_WIDTH = 1280  # [px] that the presets count in
FIELD_WIDTH = 60.0  # [px] standard deviation of the smooth field's bumps, native
FROZEN_WIDTH = 3.0  # [px] of the stream
TEMPORAL_WIDTH = 2.0  # [px] of the stream
REFERENCE_CELSIUS = 30.0
OFFSET_PER_CELSIUS = 0.015  # [px, native]
EDGE_STEP = 2.0  # [px] of disparity inside the window that makes an edge
_EDGE_WINDOW = np.ones((7, 7), dtype=np.uint8)


class Air(NamedTuple):
    """What water does to depth: 0 none, 1 a dripping person, dense steam; number of drops on the window."""

    wetness: float = 0.0
    steam: float = 0.0
    drops: int = 0


class D455:
    """One unit's depth stream at one picture size."""

    def __init__(self, sensor_seed: int, preset: Preset, width: int, height: int) -> None:
        """Make the unit's fields.

        Args:
            sensor_seed: Which unit.
            preset: Size of its errors.
            width: Of the stream [px].
            height: Of the stream [px].
        """
        self.unit = make_unit(sensor_seed, preset, width, height)
        self._preset, self._seed = preset, sensor_seed
        rng = np.random.default_rng([sensor_seed, 456])
        self._left, self._right = (imager_field(rng, preset, width, height) for _ in range(2))
        self._ratio = width / NATIVE_WIDTH
        self._constant = np.float32(self.unit.published_depth.fx * BASELINE)  # [px m]
        self._frozen: dict[int, NDArray[np.float32]] = {}

    @property
    def nearest(self) -> float:
        """Least distance the stream can see [m]."""
        return float(self._constant) / SEARCH if self._preset.artefacts else 0.0

    def measure(
        self,
        depth: NDArray[np.float32],
        rng: np.random.Generator,
        *,
        pose: int = 0,
        celsius: float = 30.0,
        air: Air = Air(),
    ) -> NDArray[np.uint16]:
        """One depth frame as the topic carries it.

        Args:
            depth: True distance along the axis of the depth camera [m], NaN where nothing, shape (H, W).
            rng: Of this frame.
            pose: Number of the still scene; the frozen noise changes with it.
            celsius: Temperature of the unit.
            air: Water on skin, in the air and on the window.

        Returns:
            Distance [mm], 0 where the unit sees none, shape (H, W).
        """
        metres = self.sense(depth, rng, pose=pose, celsius=celsius, steam=air.steam)
        millimetres = np.nan_to_num(metres * np.float32(1000.0)) + np.float32(0.5)
        measured = np.where(millimetres < 65535.0, millimetres, 0.0).astype(np.uint16)
        if air != Air():
            _wet(measured, rng, air, self._seed)
        return measured

    def sense(
        self,
        depth: NDArray[np.float32],
        rng: np.random.Generator,
        *,
        pose: int = 0,
        celsius: float = 30.0,
        steam: float = 0.0,
    ) -> NDArray[np.float32]:
        """The distances behind a frame, rounded to the preset's unit only.

        Args:
            depth: True distance along the axis of the depth camera [m], NaN where nothing, shape (H, W).
            rng: Of this frame.
            pose: Number of the still scene; the frozen noise changes with it.
            celsius: Temperature of the unit.
            steam: In the air, 0 none to 1 dense.

        Returns:
            Distance [m], NaN where the unit sees none, shape (H, W).
        """
        preset = self._preset
        with np.errstate(divide="ignore"):
            disparity = self._constant / ((1.0 + np.float32(preset.scale)) * depth.astype(np.float32))
        if preset.artefacts:
            disparity = self._edges(disparity, rng)
        noise = self._noise(disparity.shape, rng, pose, steam)
        warmth = OFFSET_PER_CELSIUS * (celsius - REFERENCE_CELSIUS) * preset.factory
        metres = np.empty(disparity.shape, dtype=np.float32)
        _sense(
            disparity,
            self._left,
            self._right,
            noise,
            np.float32(self._ratio * (preset.offset + warmth)),
            np.float32(preset.follow),
            np.float32(preset.ripple),
            np.float32(preset.subpixels),
            self._constant,
            np.float32(preset.unit),
            preset.artefacts,
            metres,
        )
        return metres

    def _noise(
        self, shape: tuple[int, int], rng: np.random.Generator, pose: int, steam: float
    ) -> NDArray[np.float32]:
        """Frozen and temporal noise of the disparity [px]."""
        preset = self._preset
        if pose not in self._frozen:
            self._frozen.clear()
            field = soft_noise(np.random.default_rng([self._seed, 457, pose]), shape, FROZEN_WIDTH)
            self._frozen[pose] = np.float32(preset.frozen) * field
        if preset.temporal == 0.0:
            return self._frozen[pose]
        strength = np.float32(preset.temporal * (1.0 + 2.0 * steam))
        return self._frozen[pose] + strength * soft_noise(rng, shape, TEMPORAL_WIDTH)

    @staticmethod
    def _edges(disparity: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
        """Pixels within 3 px of an edge: a third blind, a third flying between both sides."""
        high, low = cv2.dilate(disparity, _EDGE_WINDOW), cv2.erode(disparity, _EDGE_WINDOW)
        where = np.nonzero(high > low + EDGE_STEP)
        chance = rng.random(len(where[0]), dtype=np.float32)
        near, far = high[where], low[where]
        mixed = far + rng.random(len(near), dtype=np.float32) * (near - far)
        result = disparity.copy()
        result[where] = np.where(chance < 0.35, np.nan, np.where(chance < 0.6, mixed, result[where]))
        return result


def imager_field(rng: np.random.Generator, preset: Preset, width: int, height: int) -> NDArray[np.float32]:
    """Disparity error an imager adds to each of its pixels [px of the stream], shape (height, width).

    A tilt, a cubic radial term x r^2 and a smooth random field.
    """
    u = np.linspace(-1.0, 1.0, width)[None, :]
    v = np.linspace(-height / width, height / width, height)[:, None]
    slope = preset.tilt * rng.normal(size=2)
    radial = preset.radial * rng.uniform(0.75, 1.25) * rng.choice([-1.0, 1.0])
    sigma = FIELD_WIDTH * width / NATIVE_WIDTH / 4.0
    bumps = soft_noise(rng, (height // 4 + 1, width // 4 + 1), sigma)
    bumps = cv2.resize(bumps, (width, height), interpolation=cv2.INTER_CUBIC)
    field = slope[0] * u + slope[1] * v + radial * u * (u**2 + v**2) / (1.0 + (height / width) ** 2)
    return ((field + preset.smooth * bumps) * width / NATIVE_WIDTH).astype(np.float32)


def soft_noise(rng: np.random.Generator, shape: tuple[int, int], sigma: float) -> NDArray[np.float32]:
    """Gaussian noise of unit variance, as smooth as a Gaussian window of a width [px]."""
    white = rng.standard_normal(shape, dtype=np.float32)
    # a normalised Gaussian window leaves 1 / (2 sqrt(pi) sigma) of white noise's spread
    return cv2.GaussianBlur(white, (0, 0), sigma) * np.float32(2.0 * np.sqrt(np.pi) * sigma)


@numba.njit(cache=True, nogil=True)
def _sense(
    disparity, left, right, noise, offset, follow, ripple, subpixels, constant, unit, artefacts, out
):  # fmt: skip
    height, width = disparity.shape
    for v in range(height):
        taken = np.float32(1e9)  # leftmost pixel of the right imager that anything to the right maps to
        for k in range(width):
            u = width - 1 - k
            d = disparity[v, u]
            out[v, u] = np.nan
            if not (d > 0.0) or d > 1e6:
                continue
            match = u - d
            hidden = match >= taken - 0.5 + 1.0
            taken = min(taken, match)
            if artefacts and (match < 0.0 or hidden or d > SEARCH):
                continue
            at = min(max(u - follow * d, np.float32(0.0)), np.float32(width - 1.001))
            cell = int(at)
            share = at - cell
            d += left[v, u] - ((1.0 - share) * right[v, cell] + share * right[v, cell + 1]) + offset
            d += ripple * np.sin(2.0 * np.pi * d) + noise[v, u]
            if subpixels > 0.0:
                d = np.round(subpixels * d) / subpixels
            if d > 0.5:
                metres = constant / d
                out[v, u] = unit * np.round(metres / unit) if unit > 0.0 else metres


def _wet(measured: NDArray[np.uint16], rng: np.random.Generator, air: Air, seed: int) -> None:
    """Zeros where water glints, wrong matches, blind spots behind drops on the window, holes in steam."""
    height, width = measured.shape
    holes = np.zeros(measured.shape, dtype=np.uint8)
    _spots(holes, rng, round(0.03 * air.wetness * measured.size / 60.0), (1.5, 7.5))
    fixed = np.random.default_rng([seed, 458])
    _spots(holes, fixed, air.drops, (5.0, 20.0))
    if air.steam > 0.0:
        coarse = rng.random((height // 6 + 1, width // 6 + 1), dtype=np.float32)
        lost = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_NEAREST)
        holes |= (lost < 0.2 * min(air.steam, 1.0)).astype(np.uint8)
    measured[holes > 0] = 0
    wrong = rng.choice(measured.size, size=round(0.006 * air.wetness * measured.size))
    values = measured.ravel()
    values[wrong] = np.clip(values[wrong] * rng.uniform(0.8, 1.25, len(wrong)), 0, 65535).astype(np.uint16)


def _spots(mask: NDArray[np.uint8], rng: np.random.Generator, count: int, radii: tuple[float, float]) -> None:
    height, width = mask.shape
    centres = rng.uniform((0, 0), (width, height), size=(count, 2)).astype(int)
    for (x, y), radius in zip(centres.tolist(), rng.uniform(*radii, size=count), strict=True):
        cv2.circle(mask, (x, y), round(radius), 1, thickness=-1)
