"""One simulated D455: what it is, and what its maker wrote into it.

Published intrinsics and extrinsics are the factory's; the true ones differ a little, as on every unit. The
numbers are those of one real unit at 1280x720; other sizes are scaled. All of it follows from the sensor seed
and the preset.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import transform_from
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bathbot_bringup.errors import SettingsError

Array = NDArray[np.float64]

BASELINE = 0.095  # [m] between the two imagers
SEARCH = 126  # [px] of the widest disparity: sets the nearest distance
FACTORY_DEPTH = Pinhole(1280, 720, 641.5, 641.5, 640.4, 363.8)
FACTORY_COLOUR = Pinhole(
    1280, 720, 632.4, 632.0, 639.8, 363.3, (-0.0565, 0.0688, -0.00072, -0.00002, -0.0224)
)
COLOUR_OFFSET = (-0.059, 0.0, 0.0)  # [m] depth -> colour


@dataclass(frozen=True, slots=True)
class Preset:
    """Sizes of the errors of a unit; pixels are those of 1280x720 where not said otherwise.

    Attributes:
        scale: Relative error of focal length times baseline.
        offset: Error of the disparity [px].
        tilt: Of each imager's residual rectification, rms [px at the image's edge].
        radial: Of the same, range of the cubic term [px at the corner].
        smooth: Of the same, rms of the smooth random field [px].
        follow: How far the second imager's field follows the disparity: 1 as physics has it; 0 and 1/2 are
            sensors of another structure, on which a correction can show that it does not rely on this one.
        ripple: Amplitude of the sub-pixel error [px of the stream].
        frozen: Noise that stays as long as the scene does, rms [px of the stream].
        temporal: Noise from frame to frame, rms [px of the stream].
        artefacts: Whether edges fly, the near side is blind and foregrounds cast shadows.
        factory: Error of the published intrinsics and extrinsics, 1 as on a usual unit.
        unit: Step of the depth [m]; 0 for none, though the topic carries whole millimetres.
        subpixels: Steps of disparity per pixel; 0 for none.
    """

    scale: float = 0.0
    offset: float = 0.0
    tilt: float = 0.1
    radial: float = 0.2
    smooth: float = 0.06
    follow: float = 1.0
    ripple: float = 0.04
    frozen: float = 0.05
    temporal: float = 0.05
    artefacts: bool = True
    factory: float = 1.0
    unit: float = 0.001
    subpixels: int = 32


PRESETS = {
    "paper": Preset(scale=0.012, offset=-1.0),
    "yaw": Preset(scale=0.0, offset=-1.93),
    "good": Preset(scale=0.002, offset=-0.1),
    "half": Preset(scale=0.012, offset=-1.0, follow=0.5),
    "fixed": Preset(scale=0.012, offset=-1.0, follow=0.0),
    "perfect": Preset(
        tilt=0.0,
        radial=0.0,
        smooth=0.0,
        ripple=0.0,
        frozen=0.0,
        temporal=0.0,
        artefacts=False,
        factory=0.0,
        subpixels=0,
    ),
}


def find_preset(name: str) -> Preset:
    """Look a preset up.

    Raises:
        SettingsError: If there is none of that name.
    """
    if name not in PRESETS:
        raise SettingsError(f"no D455 preset {name!r}; there are {', '.join(PRESETS)}")
    return PRESETS[name]


def preset_name(preset: Preset) -> str:
    """Name of a preset, "custom" for sizes that have none."""
    return next((name for name, known in PRESETS.items() if known == preset), "custom")


class D455Unit(NamedTuple):
    """Cameras of one unit at one picture size; `published` is what its topics say, the rest is true.

    Attributes:
        depth: True rays of the depth stream.
        colour: True camera of the colour stream.
        T_colour_depth: True transform, maps depth points to colour points, shape (4, 4).
        published_depth: As in camera_info.
        published_colour: As in camera_info.
        published_T_colour_depth: As on extrinsics/depth_to_color.
        serial: Serial number: a map of one unit and preset fits no other.
    """

    depth: Pinhole
    colour: Pinhole
    T_colour_depth: Array
    published_depth: Pinhole
    published_colour: Pinhole
    published_T_colour_depth: Array
    serial: str


def make_unit(sensor_seed: int, preset: Preset, width: int, height: int) -> D455Unit:
    """Build the unit of a sensor seed, read out at a picture size [px].

    Raises:
        SettingsError: If the stream has no such size.
    """
    if width * 9 not in range(height * 16 - 16 * 8, height * 16 + 16 * 8) or not 320 <= width <= 1280:
        raise SettingsError(
            f"the simulated D455 has 16:9 pictures 320 to 1280 px wide, got {width}x{height}; try 848x480"
        )
    rng = np.random.default_rng([sensor_seed, 455])
    turn = preset.factory * np.deg2rad(0.15) * _direction(rng)
    shift = preset.factory * 0.0009 * _direction(rng)
    published = transform_from(translation=COLOUR_OFFSET)
    true = transform_from(Rotation.from_rotvec(turn).as_matrix(), np.add(COLOUR_OFFSET, shift))
    depth = _off_factory(FACTORY_DEPTH, rng, preset.factory)
    colour = _off_factory(FACTORY_COLOUR, rng, preset.factory)
    return D455Unit(
        depth.scaled(width, height),
        colour.scaled(width, height),
        true,
        FACTORY_DEPTH.scaled(width, height),
        FACTORY_COLOUR.scaled(width, height),
        published,
        f"SIM455-{sensor_seed:04d}-{preset_name(preset)}",
    )


def _direction(rng: np.random.Generator) -> Array:
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _off_factory(camera: Pinhole, rng: np.random.Generator, size: float) -> Pinhole:
    """The true camera behind published numbers: 0.05 % of focal length and 0.3 px of centre (rms)."""
    longer = 1.0 + size * 0.0005 * rng.normal()
    centre = size * 0.3 * rng.normal(size=2)
    return replace(
        camera,
        fx=camera.fx * longer,
        fy=camera.fy * longer,
        cx=camera.cx + centre[0],
        cy=camera.cy + centre[1],
    )
