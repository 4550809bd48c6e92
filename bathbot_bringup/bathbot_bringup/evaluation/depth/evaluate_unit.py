"""All methods on one simulated unit: the same views for each, then errors on targets it has not seen."""

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse, rotation_angle
from numpy.typing import NDArray

from bathbot_bringup.evaluation.depth.measures import Errors, Fitted, Flatness, errors, flatness
from bathbot_bringup.evaluation.depth.methods.table import all_methods
from bathbot_bringup.evaluation.depth.simulated_unit import Recording, SimulatedUnit, facing
from bathbot_bringup.evaluation.depth.targets import Target, targets, wall

FRAME_DISTANCES = (0.6, 0.7, 0.8, 0.9)  # [m] of the walls seen with noise
FRAMES = 12  # of one still wall, to tell temporal from frozen noise
NOISE_DISTANCE = 0.75  # [m] of that wall
BEHIND = 0.6  # [m] from a cylinder to the wall behind it
_EVERY = 2  # rows and columns between pixels that are compared; systematic errors are smooth


class Sample(NamedTuple):
    """Errors without noise of one method on one target."""

    method: str
    target: Target
    errors: Errors


class FrameSample(NamedTuple):
    """Errors of one method on one frame of a wall, noise and rounding included."""

    method: str
    distance: float
    errors: Errors
    flatness: Flatness


class Fit(NamedTuple):
    """What a method found: seconds it took, and its transform against the true one [deg], [mm]."""

    method: str
    seconds: float
    turn: float
    move: float


class Noise(NamedTuple):
    """Parts of the error of one method on one wall, each a root mean square over pixels [mm].

    Attributes:
        systematic: What stays without noise.
        frozen: What a long average adds to it: the noise of the texture, which stays with the scene.
        temporal: What changes from frame to frame.
    """

    method: str
    systematic: float
    frozen: float
    temporal: float


class UnitResult(NamedTuple):
    """All that was measured on one unit."""

    seed: int
    focal_change: float
    fits: list[Fit]
    samples: list[Sample]
    frames: list[FrameSample]
    noise: list[Noise]


def fit_methods(
    unit: SimulatedUnit, views: Sequence, names: Sequence[str], tell: Callable[[str], None]
) -> tuple[dict[str, Fitted], list[Fit]]:
    """Fit each method to the same views."""
    fitted, fits = {}, []
    for name in names:
        tell(f"fitting {name}")
        start = time.perf_counter()
        fitted[name] = all_methods()[name].fit(views, unit.factory)
        seconds = time.perf_counter() - start
        off = fitted[name].T_colour_depth @ inverse(unit.T_colour_depth)
        move = np.linalg.norm(fitted[name].T_colour_depth[:3, 3] - unit.T_colour_depth[:3, 3])
        turn = float(np.rad2deg(rotation_angle(off[:3, :3])))
        fits.append(Fit(name, seconds, turn, 1e3 * float(move)))
    return fitted, fits


def systematic(unit: SimulatedUnit, target: Target, fitted: dict[str, Fitted]) -> list[Sample]:
    """Errors without noise and rounding on one target."""
    truth = unit.truth(target.surface)
    judged = np.ones(truth.shape, dtype=bool)
    if target.kind == "cylinder":
        judged = facing(truth)
        behind = unit.truth(wall(target.distance + BEHIND))
        truth = np.where(np.isfinite(truth), truth, behind).astype(np.float32)
    raw = unit.clean(truth)
    found = []
    for name, correction in fitted.items():
        expected = unit.expected(target.surface, correction.T_colour_depth, _EVERY)
        expected[~judged[::_EVERY, ::_EVERY]] = np.nan
        found.append(Sample(name, target, errors(correction.apply(raw)[::_EVERY, ::_EVERY], expected)))
    return found


def one_frame(
    unit: SimulatedUnit, distance: float, pose: int, fitted: dict[str, Fitted]
) -> list[FrameSample]:
    """Errors of one frame of a frontal wall."""
    surface = wall(distance)
    raw = unit.frame(unit.truth(surface), 0, pose)
    found = []
    for name, correction in fitted.items():
        depth, expected = correction.apply(raw), unit.expected(surface, correction.T_colour_depth)
        camera, focal_baseline = unit.factory.depth_camera, unit.factory.focal_baseline
        flat = flatness(depth, expected, camera, focal_baseline)
        found.append(FrameSample(name, distance, errors(depth, expected), flat))
    return found


def split_noise(unit: SimulatedUnit, fitted: dict[str, Fitted]) -> list[Noise]:
    """Systematic, frozen and temporal error apart, on many frames of one still wall."""
    truth = unit.truth(wall(NOISE_DISTANCE))
    frames, clean = [unit.frame(truth, number, 99) for number in range(FRAMES)], unit.clean(truth)
    found = []
    for name, correction in fitted.items():
        silent = correction.apply(clean)
        stack = np.stack([correction.apply(frame)[::_EVERY, ::_EVERY] for frame in frames])
        variance = np.var(stack, axis=0, ddof=1)
        # the mean of few frames still holds some temporal noise
        lasting = np.square(stack.mean(axis=0) - silent[::_EVERY, ::_EVERY]) - variance / FRAMES
        error = silent - unit.expected(wall(NOISE_DISTANCE), correction.T_colour_depth)
        parts = (np.square(error), lasting, variance)
        found.append(Noise(name, *(1e3 * float(np.sqrt(max(0.0, np.nanmean(part)))) for part in parts)))
    return found


def evaluate_unit(
    unit: SimulatedUnit, recording: Recording, names: Sequence[str], tell: Callable[[str], None]
) -> tuple[UnitResult, dict[str, Fitted]]:
    """Calibrate one unit by every method and judge each.

    Args:
        unit: The unit.
        recording: How it is calibrated.
        names: Of the methods.
        tell: Called with what is being done.

    Returns:
        The errors, and the fitted methods.
    """
    tell("calibration views")
    views, reference = unit.calibration_views(recording)
    fitted, fits = fit_methods(unit, views, names, tell)
    samples: list[Sample] = []
    for target in targets(unit.seed):
        tell(f"{target.kind} at {target.distance:.2f} m")
        samples += systematic(unit, target, fitted)
    tell("single frames")
    single = [
        sample
        for pose, distance in enumerate(FRAME_DISTANCES)
        for sample in one_frame(unit, distance, pose, fitted)
    ]
    tell("noise")
    noise = split_noise(unit, fitted)
    return UnitResult(unit.seed, reference.focal_change, fits, samples, single, noise), fitted


def signed_map(unit: SimulatedUnit, distance: float, correction: Fitted) -> NDArray[np.float64]:
    """Signed error without noise of a frontal wall [mm], every fourth row and column."""
    surface = wall(distance)
    depth = correction.apply(unit.clean(unit.truth(surface)))[::4, ::4]
    return 1e3 * (depth - unit.expected(surface, correction.T_colour_depth, 4))
