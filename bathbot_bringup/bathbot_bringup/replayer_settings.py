"""What a user may change about the replayer; config/replayer.yaml has these keys."""

import math
from dataclasses import dataclass, field

from bathbot_bringup.errors import SettingsError


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
