"""What a user may change about the detector; config/skin_detector.yaml has the same keys."""

from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, setting

from bathbot_perception.detection.letterbox import STRIDE
from bathbot_perception.errors import SettingsError

PROVIDERS: dict[str, str] = {
    "cpu": "CPUExecutionProvider",
    "cuda": "CUDAExecutionProvider",
    "tensorrt": "TensorrtExecutionProvider",
}
"""Names of the `provider` setting and what ONNX Runtime calls them."""


@dataclass(frozen=True, slots=True)
class SkinDetectorSettings:
    """Parameters of the detector and of its node."""

    model: str = setting(
        "", "ONNX file of the network, or skin.onnx or skin_int8.onnx of the package; empty: skin.onnx"
    )
    provider: str = setting(
        "cpu", "Where the network runs; the node stops rather than run elsewhere", choices=tuple(PROVIDERS)
    )
    threads: int = setting(2, "Number of CPU threads the network may use", low=1)
    size: int = setting(
        0, "Longer side of the network's input picture; 0: as the model says", "px", low=0, step=STRIDE
    )
    score_threshold: float = setting(
        0.35, "Confidence, 0..1, below which a region is left out", low=0.0, high=1.0
    )
    overlap_limit: float = setting(
        0.5, "Overlap (intersection over union, 0..1) above which the worse of two boxes of a class is "
        "left out", low=0.0, high=1.0,
    )  # fmt: skip
    most_regions: int = setting(30, "Largest number of regions told per picture; the best ones stay", low=1)
    smoothing: float = setting(
        0.0, "Share of a region's last box that stays in the next picture, against jitter; 0: none; with "
        "more than 0.95 boxes would never arrive", low=0.0, high=0.95,
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what no detector can work with.

        Raises:
            SettingsError: With the value and what is allowed.
        """
        check(self, SettingsError)
