"""What a user may change about the recorder; config/recorder.yaml has these keys."""

from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, setting

from bathbot_bringup.errors import SettingsError


@dataclass(frozen=True, slots=True)
class RecorderSettings:
    """Where and what to record."""

    bag: str = setting("", "Bag to make: a new folder, or a new file ending in .mcap; empty is refused")
    profile: str = setting("metrics_only", "Name of the privacy profile, which says what is recorded")
    who: str = setting("", "Who agreed to be recorded; privacy profiles with pictures need it")
    when: str = setting("", "When they agreed, such as 2026-01-31; likewise")
    why: str = setting("", "What they agreed to: the purpose, and how long it is kept; likewise")
    profiles: str = setting(
        "", "File of privacy profiles; empty: privacy_profiles.yaml of the package bathbot_bringup"
    )
    search_period: float = setting(
        0.2, "Time between two looks for topics that have appeared", "s", low=0.05, high=10.0
    )
    queue_megabytes: int = setting(
        256, "Size of the messages that may wait for the disk; more are dropped and counted", "MB", low=1
    )

    def __post_init__(self) -> None:
        """Refuse values that mean nothing.

        Raises:
            SettingsError: With the value and what is allowed.
        """
        check(self, SettingsError)
