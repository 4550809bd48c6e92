"""What a user may change of the depth corrector; `config/depth_corrector.yaml` has these keys."""

from dataclasses import dataclass

from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.node.parameters import check, setting

_NO_ROI = (0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class Settings:
    """Parameters of `depth_corrector`."""

    calibration: str = setting(
        "", "Path of the camera's depth calibration, an .npz file; empty: depth passes uncorrected"
    )
    serial: str = setting(
        "", "Serial number of the camera that is connected; empty: learnt from the camera's /diagnostics"
    )
    max_depth: float = setting(
        4.0, "Depth beyond which a pixel becomes NaN; a D455 sees 0.4 to 6 m", "m", above=0.1
    )
    publish_mm: bool = setting(
        False, "Whether to publish depth/corrected/image_mm as well, the same depth as 16UC1 millimetres"
    )
    max_temperature_change: float = setting(
        8.0, "Difference of the depth chip's temperature from its calibration above which the node warns",
        "degC", above=0.0,
    )  # fmt: skip
    wall_distance: float = setting(
        0.0, "True depth of a wall before the camera, to tell the z_accuracy on /diagnostics, measured "
        "from the left imager, which lies 4.5 mm behind a D455's front glass; 0: unknown", "m", low=0.0,
        below=10.0,
    )  # fmt: skip
    registered_roi: tuple[int, ...] = setting(
        _NO_ROI, "Left, top, width and height, in the colour picture, of the region that "
        "depth/registered/image shows; 0, 0, 0, 0: it is not published", "px", length=4,
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse values no camera can meet.

        Raises:
            SettingsError: With the value and what is allowed.
        """
        check(self, SettingsError)
        if self.registered_roi != _NO_ROI and not _is_roi(self.registered_roi):
            raise SettingsError(
                f"registered_roi must be left, top, width, height in pixels, got {list(self.registered_roi)}"
                "; 0, 0, 0, 0 turns it off"
            )


def _is_roi(values: tuple[int, ...]) -> bool:
    whole = all(isinstance(value, int) for value in values)
    return whole and min(values[:2]) >= 0 and min(values[2:]) > 0
