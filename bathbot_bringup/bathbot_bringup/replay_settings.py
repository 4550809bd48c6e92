"""What a replay was asked to do, and the parameters that its nodes get."""

from dataclasses import dataclass
from pathlib import Path

from bathbot_bringup.errors import InputError
from bathbot_bringup.recorder import refuse_existing
from bathbot_bringup.share import SIM_CALIBRATION, SIM_HAND_EYE, config_file


@dataclass(frozen=True, slots=True)
class ReplaySettings:
    """What `bathbot replay` was asked to do."""

    bag: Path
    rate: float
    out: Path | None
    calibration: str
    hand_eye: str

    def __post_init__(self) -> None:
        """Refuse files that are not there.

        Raises:
            InputError: Names the file.
        """
        for file in filter(None, (self.calibration, self.hand_eye)):
            if not Path(file).is_file():
                raise InputError(f"there is no calibration {file}; `bathbot calibrate` makes one")
        if self.out is not None:
            refuse_existing(self.out)

    def parameters(self, node: str) -> dict[str, object]:
        """Parameters of one node of the replay."""
        depth = self.calibration or SIM_CALIBRATION
        hand_eye = self.hand_eye or config_file("bathbot_bringup", SIM_HAND_EYE)
        return {
            "depth_corrector": {"calibration": depth, "use_sim_time": True},
            "skin_detector": {"use_sim_time": True},
            "target_localizer": {"hand_eye": hand_eye, "use_sim_time": True},
            "recorder": {"bag": self.out.absolute() if self.out else ""},
            "replayer": {"bag": self.bag.absolute(), "rate": self.rate},
        }[node]
