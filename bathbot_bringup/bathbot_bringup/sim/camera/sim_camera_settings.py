"""What a user may change of the simulated camera; `config/sim_camera.yaml` has these keys."""

from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, setting

from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.camera.d455_unit import PRESETS, D455Unit, Preset, find_preset, make_unit
from bathbot_bringup.sim.scenario import Scenario, load_scenario

SCENES = ("bathroom", "chessboard", "aruco")


@dataclass(frozen=True, slots=True)
class SimCameraSettings:
    """Parameters of the simulated D455 and of what stands before it."""

    scene: str = setting(
        "bathroom", "What the camera sees: a person in a bathroom, a chessboard on a wall before which the "
        "camera moves, or an ArUco marker on the arm's flange", choices=SCENES,
    )  # fmt: skip
    seed: int = setting(
        0, "Seed of the person, of the room and of the pictures' noise; the same as that of sim_rm65", low=0,
        high=2**31,
    )  # fmt: skip
    scenario: str = setting(
        "calm", "How the person moves: a name or a YAML file; the same as that of sim_rm65"
    )
    epoch: float = setting(
        0.0, "ROS time at which the person's motion begins, the same as that of sim_rm65; 0: when the node "
        "starts", "s", low=0.0,
    )  # fmt: skip
    rate: float = setting(
        6.0, "Rate aimed at, of pairs of colour and depth pictures", "Hz", low=0.1, high=90.0
    )
    width: int = setting(848, "Width of colour and depth pictures, 320 to 1280; they are 16:9", "px")
    height: int = setting(480, "Height of colour and depth pictures; they are 16:9", "px")
    preset: str = setting("paper", "Size of the errors of depth", choices=tuple(PRESETS))
    sensor_seed: int = setting(
        1, "Which unit of the camera is simulated; its serial number is "
        "SIM455-<sensor_seed>-<preset>", low=0,
        high=9999,
    )  # fmt: skip
    celsius: float = setting(30.0, "Temperature of the camera's depth chip", "degC", low=-10.0, high=70.0)
    colour_noise: float = setting(
        2.0, "Noise of the colour picture, root mean square, where white is 255", low=0.0, high=50.0
    )
    poses: int = setting(
        30, "Number of places at which the camera stands in the scene chessboard", low=1, high=500
    )
    hold: float = setting(
        1.6, "Time for which the camera stands still at each place in the scene chessboard", "s", low=0.2,
        high=3600.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what no camera does.

        Raises:
            SettingsError: With the value and what is allowed.
        """
        check(self, SettingsError)
        self.errors()
        self.motion()

    def errors(self) -> Preset:
        """Size of the depth errors."""
        return find_preset(self.preset)

    def unit(self) -> D455Unit:
        """The camera's unit, read out at the pictures' size."""
        return make_unit(self.sensor_seed, self.errors(), self.width, self.height)

    def motion(self) -> Scenario:
        """How the person moves."""
        return load_scenario(self.scenario)
