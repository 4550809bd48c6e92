"""What a replay was asked to do, and the parameters that its nodes get."""

from dataclasses import dataclass
from pathlib import Path

from bathbot_depthcorr.node.parameters import check, setting

from bathbot_bringup.bag.recording.mcap_bag import refuse_existing
from bathbot_bringup.errors import InputError, SettingsError
from bathbot_bringup.graph.installation import SIM_CALIBRATION, SIM_HAND_EYE, config_file


@dataclass(frozen=True, slots=True)
class ReplayerSettings:
    """What to publish again, and how fast."""

    bag: str = setting("", "Bag to publish again: a rosbag2 folder or an .mcap file; empty is refused")
    rate: float = setting(
        1.0, "Speed of the replay; 1 is as fast as it was recorded, 2 twice as fast", low=0.05, high=20.0
    )
    sources_only: bool = setting(
        True, "Whether to leave out what the pipeline makes itself, where the bag holds pictures"
    )
    clock: bool = setting(True, "Whether to publish the recorded time on /clock, for nodes with use_sim_time")
    wait_for_listeners: float = setting(
        5.0, "Longest time to wait for somebody who listens to the bag's topics", "s", low=0.0, high=60.0
    )

    def __post_init__(self) -> None:
        """Refuse values that mean nothing.

        Raises:
            SettingsError: With the value and what is allowed.
        """
        check(self, SettingsError)


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
