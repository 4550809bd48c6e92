"""How hard each region may be touched: `config/force_limits.yaml` as frozen dataclasses."""

import math
import os
from dataclasses import dataclass, fields
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml
from bathbot_depthcorr.bounded_files import read_yaml
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead

from bathbot_scrub.arm.collision_table import quasi_static
from bathbot_scrub.arm.errors import ArmSettingsError, NotReadyError

_SINGLE = ("contact", "zero_residual", "transit", "surge", "give")
_SPARE = 0.003  # [m] of give that a press leaves: a body breathes by 2 mm, depth errs by 1 mm
_NAME = Path("config") / "force_limits.yaml"

# What no file may pass. Where a number is not from the literature, it says what it would mean to pass it.
_MOST_HARD_STOP = 25.0  # [N] at which a robot that cleaned people gave up: `CleanHuman`, visual-force-torque
_MOST_HARD_STOP_FACE = 11.0  # [N] peak with which people shave their own face: SAGE 09544119231179568
_MOST = {
    "contact": 2.0,  # [N] countertop wiping, moveit2-contact-wiping; half of what a face bears
    "zero_residual": 1.0,  # [N] lowest value of the comfort band: more would be skin, zeroed away
    "transit": 6.0,  # [N] upper end of the comfort band: more, met in free air, is a person
    "surge": 60.0,  # [N/s] a body that comes at 150 mm/s into bristles of 0.4 N/mm
    "give": 6.0,  # [N] upper end of the comfort band: bristles stiffer than that are no soft brush
}


@dataclass(frozen=True, slots=True)
class RegionLimits:
    """Limits of one region of skin; forces [N] at the scrub head after zeroing."""

    comfort: tuple[float, float]  # band that feels comfortable
    retract: float  # above this the arm leaves
    hard_stop: float  # above this it also needs a person to go on
    axis: tuple[float, float, float]  # largest |force| along x, y, z of the head
    torque: float  # [Nm] largest, about the tip
    collision: float  # outer bound of the collision table

    def __post_init__(self) -> None:
        """Refuse limits in the wrong order."""
        rising = (0.0, *self.comfort, self.retract, self.hard_stop, self.collision)
        if not all(a < b for a, b in pairwise(rising)):
            raise ArmSettingsError(
                f"limits must rise: 0 < comfort < retract < hard_stop < collision, got {rising[1:]} N"
            )
        if not (min(self.axis) > 0.0 and self.torque > 0.0):
            raise ArmSettingsError(
                f"axis and torque must be positive, got {self.axis} N and {self.torque} Nm"
            )

    def stricter(self, other: "RegionLimits") -> "RegionLimits":
        """Limits that hold for both, whichever skin the head is on."""
        return RegionLimits(
            comfort=(min(self.comfort[0], other.comfort[0]), min(self.comfort[1], other.comfort[1])),
            retract=min(self.retract, other.retract),
            hard_stop=min(self.hard_stop, other.hard_stop),
            axis=(
                min(self.axis[0], other.axis[0]),
                min(self.axis[1], other.axis[1]),
                min(self.axis[2], other.axis[2]),
            ),
            torque=min(self.torque, other.torque),
            collision=min(self.collision, other.collision),
        )


@dataclass(frozen=True, slots=True)
class ForceLimits:
    """Limits of all regions."""

    contact: float  # [N] at which skin counts as felt
    zero_residual: float  # [N] that may remain after zeroing
    transit: float  # [N] met in free air at which the arm goes back
    surge: float  # [N/s] rise at which the head leaves the skin if it must hurry
    give: float  # [N] at which the bristles have no give left
    regions: dict[str, RegionLimits]

    def __post_init__(self) -> None:
        """Refuse a contact threshold that no region allows, or that zeroing may leave, and what hurts."""
        if not 0.0 < self.zero_residual < self.contact:
            raise ArmSettingsError(
                f"need 0 < zero_residual < contact, got {self.zero_residual} and {self.contact} N"
            )
        if not (self.surge > 0.0 and self.transit > self.zero_residual):
            raise ArmSettingsError(
                f"need surge > 0 and transit > zero_residual, got {self.surge} N/s and {self.transit} N"
            )
        for name, region in self.regions.items():
            if not self.contact < region.retract:
                raise ArmSettingsError(
                    f"contact {self.contact} N must lie below retract {region.retract} N of {name}"
                )
        if not self.contact < self.used_up:
            raise ArmSettingsError(
                f"contact {self.contact} N must lie below give {self.give} N by more than zero_residual, "
                f"{self.zero_residual} N"
            )
        for name, most in _MOST.items():
            _demand_at_most(name, getattr(self, name), most)
        for name, region in self.regions.items():
            _check_bounds(name, region)

    @property
    def used_up(self) -> float:
        """Force [N] at which the give counts as used: a reading may be off by what zeroing may leave."""
        return self.give - self.zero_residual

    def region(self, name: str) -> RegionLimits:
        """Limits of one region.

        Raises:
            ArmSettingsError: When the file has none for it.
        """
        if name not in self.regions:
            raise ArmSettingsError(
                f"no force limits for region {name!r}; known are {', '.join(self.regions)}"
            )
        return self.regions[name]

    def comfortable(self, name: str, compression: float, head: ScrubHead = SCRUB_HEAD) -> float:
        """The compression [m] nearest to the one wanted whose force lies in a region's comfort band.

        Raises:
            ArmSettingsError: When the file has no such region.
        """
        least, most = self.region(name).comfort
        stiffness = self.give / head.give
        deepest = self.used_up / stiffness - _SPARE
        return min(max(compression, least / stiffness), most / stiffness, deepest)

    def check_zeroed(self, residual: float) -> None:
        """Refuse a zeroing that leaves too much.

        Raises:
            NotReadyError: With what remains [N].
        """
        if not residual <= self.zero_residual:
            raise NotReadyError(
                f"{residual:.2f} N remain after zeroing, more than {self.zero_residual} N; "
                "is the arm at rest and free?"
            )

    def gentlest(self) -> RegionLimits:
        """Limits that hold wherever the head may be: those of the region that bears least."""
        return min(self.regions.values(), key=lambda region: region.retract)


def _check_bounds(name: str, region: RegionLimits) -> None:
    """Refuse limits of a region beyond what its skin bears; a class that no table knows counts as a face."""
    _demand_at_most(f"{name}.collision", region.collision, quasi_static(name))
    known_to_bear_more = quasi_static(name) > quasi_static("Face_skin")
    _demand_at_most(
        f"{name}.hard_stop",
        region.hard_stop,
        _MOST_HARD_STOP if known_to_bear_more else _MOST_HARD_STOP_FACE,
    )
    _demand_at_most(f"{name}.axis", max(region.axis), region.hard_stop)
    _demand_at_most(f"{name}.torque", region.torque, region.hard_stop * SCRUB_HEAD.brush_radius)


def _demand_at_most(name: str, value: float, most: float) -> None:
    if not value <= most:
        raise ArmSettingsError(
            f"{name} must be at most {most:g}, got {value:g}; docs/safety.md says where the bound comes from"
        )


def default_file() -> Path:
    """The file of this checkout, or of the installed package."""
    places = [Path(__file__).parents[2]]
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        places.append(Path(prefix) / "share" / "bathbot_scrub")
    return next((place / _NAME for place in places if (place / _NAME).is_file()), places[0] / _NAME)


def load_force_limits(path: str | Path = "") -> ForceLimits:
    """Read a limits file; the default one when `path` is empty.

    Raises:
        ArmSettingsError: One line that names the file and what is wrong in it.
    """
    file = Path(path) if str(path) else default_file()
    try:
        return _parse(read_yaml(file))
    except (OSError, UnicodeDecodeError) as error:
        raise ArmSettingsError(f"cannot read force limits {file}: {error}") from error
    except yaml.YAMLError as error:
        raise ArmSettingsError(f"force limits {file} are not YAML: {' '.join(str(error).split())}") from error
    except ArmSettingsError as error:
        raise ArmSettingsError(f"force limits {file}: {error}") from error


def _parse(content: Any) -> ForceLimits:
    _check_keys(content, ForceLimits, "the file")
    if not isinstance(content["regions"], dict) or not content["regions"]:
        raise ArmSettingsError("regions must be a table of class names")
    regions = {}
    for name, entry in content["regions"].items():
        _check_keys(entry, RegionLimits, str(name))
        values = {key: _number(f"{name}.{key}", value) for key, value in entry.items()}
        if not (_length(values["comfort"]) == 2 and _length(values["axis"]) == 3):
            raise ArmSettingsError(f"{name}: comfort must be two numbers and axis three")
        if any(_length(values[key]) for key in ("retract", "hard_stop", "torque", "collision")):
            raise ArmSettingsError(
                f"{name}: retract, hard_stop, torque and collision must be one number each"
            )
        regions[str(name)] = RegionLimits(**values)
    single = {name: _number(name, content[name]) for name in _SINGLE}
    if any(_length(value) for value in single.values()):
        raise ArmSettingsError(f"{', '.join(_SINGLE)} must be one number each")
    return ForceLimits(**single, regions=regions)


def _check_keys(entry: Any, wanted: type, where: str) -> None:
    names = {field.name for field in fields(wanted)}
    found = set(entry) if isinstance(entry, dict) else set()
    if found != names:
        missing, unknown = sorted(names - found), sorted(map(str, found - names))
        raise ArmSettingsError(
            f"{where} lacks {missing} and has unknown {unknown}; needed are {sorted(names)}"
        )


def _number(where: str, value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_number(where, item) for item in value)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ArmSettingsError(f"{where} must be a finite number, got {value!r}")
    return float(value)


def _length(value: Any) -> int:
    return len(value) if isinstance(value, tuple) else 0


@lru_cache(maxsize=1)
def shipped_force_limits() -> ForceLimits:
    """The limits this package comes with."""
    return load_force_limits()
