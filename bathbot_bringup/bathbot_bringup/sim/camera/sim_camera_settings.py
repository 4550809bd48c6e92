"""What a user may change of the simulated camera; `config/sim_camera.yaml` has these keys."""

from dataclasses import dataclass, field
from typing import Any

from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.camera.d455_unit import Preset, find_preset
from bathbot_bringup.sim.scenario import Scenario, load_scenario

SCENES = ("bathroom", "chessboard", "aruco")


def _about(default: Any, text: str) -> Any:
    return field(default=default, metadata={"help": text})


@dataclass(frozen=True, slots=True)
class SimCameraSettings:
    """Parameters of the simulated D455 and of what stands before it."""

    scene: str = _about("bathroom", "what the camera sees: bathroom, chessboard or aruco")
    seed: int = _about(0, "of the person, of the room and of the noise; as in sim_rm65")
    scenario: str = _about("calm", "name or YAML file of how the person moves; as in sim_rm65")
    epoch: float = _about(
        0.0, "ROS time at which the motion begins [s], shared with sim_rm65; 0: when the node starts"
    )
    rate: float = _about(6.0, "pictures per second that are aimed at")
    width: int = _about(848, "of both pictures [px]")
    height: int = _about(480, "of both pictures [px]")
    preset: str = _about("paper", "size of the depth errors: paper, yaw, good or perfect")
    sensor_seed: int = _about(1, "which unit; its serial number is SIM455-<seed>")
    celsius: float = _about(30.0, "temperature of the unit")
    colour_noise: float = _about(2.0, "noise of the colour picture, rms of 255")
    poses: int = _about(30, "chessboard: number of places the camera stands at")
    hold: float = _about(1.6, "chessboard: how long it stands still at each [s]")

    def __post_init__(self) -> None:
        """Refuse what no camera does."""
        if self.scene not in SCENES:
            raise SettingsError(f"no scene {self.scene!r}; there are {', '.join(SCENES)}")
        for name, least, most in (
            ("seed", 0, 2**31), ("sensor_seed", 0, 9999), ("epoch", 0.0, float("inf")), ("rate", 0.1, 90.0),
            ("celsius", -10.0, 70.0), ("colour_noise", 0.0, 50.0), ("poses", 1, 500), ("hold", 0.2, 3600.0),
        ):  # fmt: skip
            if not least <= getattr(self, name) <= most:
                raise SettingsError(f"{name} must lie between {least} and {most}, got {getattr(self, name)}")
        self.errors()
        self.motion()

    def errors(self) -> Preset:
        """Size of the depth errors."""
        return find_preset(self.preset)

    def motion(self) -> Scenario:
        """How the person moves."""
        return load_scenario(self.scenario)
