"""What a user may change of the depth corrector."""

from dataclasses import dataclass, field

from bathbot_depthcorr.errors import SettingsError

_NO_ROI = (0, 0, 0, 0)


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

    wall_distance: float = field(
        default=0.0,
        metadata={"help": "true depth of a wall before the camera, for z_accuracy; 0: unknown [m]"},
    )
    registered_roi: tuple[int, ...] = field(
        default=(0, 0, 0, 0),
        metadata={
            "help": "left, top, width, height of depth/registered/image in colour; 0, 0, 0, 0: off [px]"
        },
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
        if not 0.0 <= self.wall_distance < 10.0:
            raise SettingsError(
                f"wall_distance must be 0 (unknown) or below 10 m, got {self.wall_distance}; measure from "
                "the left imager, which lies 4.5 mm behind a D455's front glass"
            )
        if self.registered_roi != _NO_ROI and not _is_roi(self.registered_roi):
            raise SettingsError(
                f"registered_roi must be left, top, width, height in pixels, got {list(self.registered_roi)}"
                "; 0, 0, 0, 0 turns it off"
            )


def _is_roi(values: tuple[int, ...]) -> bool:
    whole = len(values) == 4 and all(isinstance(value, int) for value in values)
    return whole and min(values[:2]) >= 0 and min(values[2:]) > 0
