"""What a user may change about the demo."""

import math
from dataclasses import dataclass
from pathlib import Path

from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.geometry.camera_unit import OtherCameraError

from bathbot_bringup.bathing.steps import full_region_name
from bathbot_bringup.errors import SettingsError
from bathbot_bringup.graph.installation import SIM_CALIBRATION
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings
from bathbot_bringup.sim.scenario import load_scenario

PRESETS = ("paper", "yaw", "good")


@dataclass(frozen=True, slots=True)
class DemoSettings:
    """One bathing job in the simulated bathroom.

    Attributes:
        region: Full class name of the region to bathe.
        seed: Of body, skin tone, pose, motion and noise.
        scenario: How the person moves: a name or a YAML file.
        out: Folder for bag, summary, report and logs.
        duration: Longest time of scrubbing [s].
        rate: Pictures per second of the simulated camera [Hz].
        preset: Error model of the simulated depth camera.
        calibration: Of that camera's depth.
    """

    region: str
    seed: int
    scenario: str
    out: Path
    duration: float = 60.0
    rate: float = 5.0
    preset: str = "paper"
    calibration: Path = SIM_CALIBRATION

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated.

        Raises:
            BringupError: In one line, with the value and what to try.
        """
        full_region_name(self.region)
        load_scenario(self.scenario)
        if not 0 <= self.seed < 2**31:
            raise SettingsError(f"seed must lie in 0..2147483647, got {self.seed}; try 0")
        if not (math.isfinite(self.duration) and 1.0 <= self.duration <= 600.0):
            raise SettingsError(f"duration must lie in 1..600 s, got {self.duration}; try 60")
        if not (math.isfinite(self.rate) and 1.0 <= self.rate <= 60.0):
            raise SettingsError(f"rate must lie in 1..60 Hz, got {self.rate}; try 5")
        if self.preset not in PRESETS:
            raise SettingsError(f"no preset is named {self.preset!r}; there are {', '.join(PRESETS)}")
        self._refuse_other_camera()
        if self.out.exists() and not self.out.is_dir():
            raise SettingsError(f"{self.out} is a file; give a folder for the results")

    def _refuse_other_camera(self) -> None:
        """Refuse a calibration of another unit or preset: it would put targets centimetres off."""
        camera, calibrated = SimCameraSettings(preset=self.preset).unit(), load(self.calibration).unit
        try:
            calibrated.refuse_other(camera.published_depth, camera.serial)
        except OtherCameraError as error:
            mine, other = f"{self.preset}.npz", calibrated.serial != camera.serial
            why = f"is for camera {calibrated.serial or 'unnamed'}" if other else f"does not fit: {error}"
            raise SettingsError(
                f"calibration {self.calibration.name} {why}, preset {self.preset} simulates "
                f"{camera.serial}; make its own with `bathbot simulate board "
                f"--preset {self.preset} --out wall && bathbot calibrate depth wall --out {mine}` and add "
                f"--calibration {mine}"
            ) from error
