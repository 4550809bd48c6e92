"""What a user may change about the recorder; config/recorder.yaml has these keys."""

from dataclasses import dataclass, field

from bathbot_bringup.errors import SettingsError


@dataclass(frozen=True, slots=True)
class RecorderSettings:
    """Where and what to record."""

    bag: str = field(
        default="", metadata={"help": "bag to make: a new folder, or a new file ending in .mcap"}
    )
    profile: str = field(default="default", metadata={"help": "name of a privacy profile"})
    consent: str = field(
        default="", metadata={"help": "who agreed to be recorded, and when; profiles with images need it"}
    )
    profiles: str = field(
        default="", metadata={"help": "file of privacy profiles; empty: the one of this package"}
    )
    search_period: float = field(default=0.5, metadata={"help": "[s] between two looks for new topics"})
    queue_megabytes: int = field(
        default=256, metadata={"help": "messages waiting for the disk; more are dropped"}
    )

    def __post_init__(self) -> None:
        """Refuse values that mean nothing.

        Raises:
            SettingsError: With the value and what to try.
        """
        if not 0.05 <= self.search_period <= 10.0:
            raise SettingsError(f"search_period must lie in 0.05..10 s, got {self.search_period}; try 0.5")
        if self.queue_megabytes < 1:
            raise SettingsError(f"queue_megabytes must be positive, got {self.queue_megabytes}; try 256")
