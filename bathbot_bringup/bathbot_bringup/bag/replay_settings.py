"""What a replay was asked to do, and the parameters that its nodes get."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from bathbot_bringup.bag.recorder import refuse_existing
from bathbot_bringup.errors import InputError, SettingsError
from bathbot_bringup.graph.installation import SIM_CALIBRATION, SIM_HAND_EYE, config_file


@dataclass(frozen=True, slots=True)
class ReplayerSettings:
    """What to publish again, and how fast."""

    bag: str = field(default="", metadata={"help": "rosbag2 folder or .mcap file"})
    rate: float = field(default=1.0, metadata={"help": "speed; 1 is as fast as it was recorded"})
    sources_only: bool = field(
        default=True,
        metadata={"help": "leave out what the pipeline makes itself, when the bag holds pictures"},
    )
    clock: bool = field(default=True, metadata={"help": "publish /clock, for nodes with use_sim_time"})
    wait_for_listeners: float = field(
        default=5.0, metadata={"help": "[s] to wait for somebody who listens to the bag"}
    )

    def __post_init__(self) -> None:
        """Refuse values that mean nothing.

        Raises:
            SettingsError: With the value and what to try.
        """
        if not (math.isfinite(self.rate) and 0.05 <= self.rate <= 20.0):
            raise SettingsError(f"rate must lie in 0.05..20, got {self.rate}; try 1.0")
        if not 0.0 <= self.wait_for_listeners <= 60.0:
            raise SettingsError(
                f"wait_for_listeners must lie in 0..60 s, got {self.wait_for_listeners}; try 5.0"
            )


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
