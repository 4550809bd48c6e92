"""What a user may change of the depth corrector."""

from dataclasses import dataclass, field

from bathbot_depthcorr.errors import SettingsError


@dataclass(frozen=True, slots=True)
class Settings:
    """Parameters of `depth_corrector`; `config/depth_corrector.yaml` has these keys."""

    calibration: str = field(
        default="", metadata={"help": "path of the .npz calibration; empty: depth passes uncorrected"}
    )
    serial: str = field(
        default="", metadata={"help": "serial number of the camera; empty: learnt from /diagnostics"}
    )
    max_depth: float = field(default=4.0, metadata={"help": "farther depth becomes NaN [m]"})
    publish_mm: bool = field(default=False, metadata={"help": "also publish depth/corrected/image_mm, 16UC1"})
    max_temperature_change: float = field(
        default=8.0, metadata={"help": "warn when the chip differs more from its calibration [deg C]"}
    )

    def __post_init__(self) -> None:
        """Refuse values no camera can meet."""
        if not self.max_depth > 0.1:
            raise SettingsError(
                f"max_depth must be above 0.1 m, got {self.max_depth}; a D455 sees 0.4 to 6 m"
            )
        if not self.max_temperature_change > 0.0:
            raise SettingsError(
                f"max_temperature_change must be positive, got {self.max_temperature_change} deg C"
            )
