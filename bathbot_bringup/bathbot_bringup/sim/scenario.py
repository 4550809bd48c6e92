"""How the person moves and what fails: a scenario from a YAML file, and the motion as a function of time.

Time is t = ROS time - epoch [s], so the camera and the arm's emulator see the same body without talking.
"""

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from bathbot_depthcorr.bounded_files import read_yaml
from bathbot_depthcorr.geometry.rigid import transform_from
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.faults.faults import Fault, parse_fault

SCENARIOS = Path(__file__).parent / "data" / "scenarios"


@dataclass(frozen=True, slots=True)
class Shift:
    """One move of the whole body that lasts.

    Attributes:
        time: When it begins [s].
        duration: How long it takes [s].
        offset: By how much, in the body frame [m].
        turn_deg: Turn about the vertical [deg].
        lean_deg: Lean forward about the seat [deg].
    """

    time: float
    duration: float = 0.4
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn_deg: float = 0.0
    lean_deg: float = 0.0

    def progress(self, t: float) -> float:
        """Share of the move done at a time [s], 0..1, smooth in speed and acceleration."""
        s = min(max((t - self.time) / self.duration, 0.0), 1.0)
        return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a person does and the air they sit in; the keys of a file in `scenarios/`.

    Attributes:
        breath_amplitude: Of the front of the chest [m].
        breath_rate: [Hz].
        sway_amplitude: Of the whole body [m].
        shifts: Moves that last.
        steam: Optical thickness of the air at one metre.
        wetness: Of the skin as depth sees it, 0..1.
        drops: Number of drops on the camera's window.
        faults: Of the arm's emulator, from its start on.
    """

    breath_amplitude: float = 0.0
    breath_rate: float = 0.25
    sway_amplitude: float = 0.0
    shifts: tuple[Shift, ...] = ()
    steam: float = 0.0
    wetness: float = 0.0
    drops: int = 0
    faults: tuple[Fault, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what no seated person does."""
        for name, most in (("breath_amplitude", 0.02), ("breath_rate", 2.0), ("sway_amplitude", 0.05),
                           ("steam", 2.0), ("wetness", 1.0), ("drops", 50)):  # fmt: skip
            value = getattr(self, name)
            if not 0.0 <= value <= most:
                raise SettingsError(f"scenario {name} must lie between 0 and {most}, got {value}")
        if any(shift.duration <= 0.0 for shift in self.shifts):
            raise SettingsError(
                "a shift of a scenario must last longer than 0 s; remove it or set its duration"
            )


def scenario_names() -> list[str]:
    """The scenarios that come with the simulator."""
    return sorted(path.stem for path in SCENARIOS.glob("*.yaml"))


def load_scenario(name: str) -> Scenario:
    """Read a scenario by its name, or by the path of a YAML file.

    Raises:
        SettingsError: If there is none, or it holds an unknown key or a wrong value.
    """
    path = Path(name) if name.endswith((".yaml", ".yml")) else SCENARIOS / f"{name}.yaml"
    if not path.is_file():
        raise SettingsError(
            f"no scenario {name!r}; there are {', '.join(scenario_names())}, or give a .yaml file"
        )
    try:
        content = read_yaml(path) or {}
        known = {field.name for field in fields(Scenario)}
        if unknown := set(content) - known:
            raise SettingsError(
                f"scenario {path.name} has an unknown key {unknown.pop()}; known are {sorted(known)}"
            )
        shifts = tuple(Shift(**{**entry, "offset": tuple(entry.get("offset", (0.0, 0.0, 0.0)))})
                       for entry in content.pop("shifts", ()))  # fmt: skip
        faults = tuple(parse_fault(entry) for entry in content.pop("faults", ()))
        return Scenario(shifts=shifts, faults=faults, **content)
    except (yaml.YAMLError, TypeError, AttributeError) as error:
        raise SettingsError(f"scenario {path.name} cannot be read: {' '.join(str(error).split())}") from error


class BodyState(NamedTuple):
    """Where a body is at one time.

    Attributes:
        T_rest_moved: Rigid move in the body frame, maps rest coordinates to moved ones, shape (4, 4).
        breath: How far the front of the chest stands out [m].
    """

    T_rest_moved: NDArray[np.float64]
    breath: float


@dataclass(frozen=True, slots=True)
class BodyMotion:
    """The motion of one person: the same for the same scenario, seed and time."""

    scenario: Scenario
    seed: int
    _phase: float = field(init=False, repr=False, compare=False)  # of the breath
    _rates: NDArray[np.float64] = field(init=False, repr=False, compare=False)  # of the sway [rad/s], (3, 3)
    _phases: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Draw how this person breathes and sways."""
        rng = np.random.default_rng([self.seed, 4401])
        object.__setattr__(self, "_phase", rng.uniform(0.0, 2.0 * np.pi))
        object.__setattr__(self, "_rates", 2.0 * np.pi * rng.uniform(0.05, 0.25, size=(3, 3)))
        object.__setattr__(self, "_phases", rng.uniform(0.0, 2.0 * np.pi, size=(3, 3)))

    def at(self, t: float) -> BodyState:
        """Where the body is at time t [s]."""
        scenario = self.scenario
        breath = scenario.breath_amplitude * np.sin(2.0 * np.pi * scenario.breath_rate * t + self._phase)
        waves = np.sin(self._rates * t + self._phases).sum(axis=1) / 3.0
        offset = scenario.sway_amplitude * waves * (1.0, 1.0, 0.2)
        turn = lean = 0.0
        for shift in scenario.shifts:
            done = shift.progress(t)
            offset = offset + done * np.asarray(shift.offset)
            turn, lean = turn + done * shift.turn_deg, lean + done * shift.lean_deg
        rotation = Rotation.from_euler("zy", [turn, lean], degrees=True).as_matrix() if turn or lean else None
        return BodyState(transform_from(rotation, offset), float(breath))
