"""What a user may change about the detector; config/skin_detector.yaml has the same keys."""

from dataclasses import dataclass, field

from bathbot_perception.detection.letterbox import STRIDE
from bathbot_perception.errors import SettingsError

PROVIDERS: dict[str, str] = {
    "cpu": "CPUExecutionProvider",
    "cuda": "CUDAExecutionProvider",
    "tensorrt": "TensorrtExecutionProvider",
}
"""Names of the `provider` setting and what ONNX Runtime calls them."""


def _setting(default: object, meaning: str) -> object:
    return field(default=default, metadata={"help": meaning})


@dataclass(frozen=True, slots=True)
class SkinDetectorSettings:
    """Parameters of the detector and of its node."""

    model: str = _setting("", "ONNX file, or skin.onnx or skin_int8.onnx of the package; empty: the first")
    provider: str = _setting(
        "cpu", "where the network runs: cpu, cuda or tensorrt; never another than asked for"
    )
    threads: int = _setting(2, "CPU threads of the network")
    size: int = _setting(0, "longer side of the network's input [px], a multiple of 32; 0: as the model says")
    score_threshold: float = _setting(0.35, "regions below this score are dropped, 0..1")
    overlap_limit: float = _setting(
        0.5, "of two boxes of a class that overlap more (IoU), the better stays, 0..1"
    )
    most_regions: int = _setting(30, "regions per picture at most, the best ones")
    smoothing: float = _setting(
        0.0, "share of a region's last box that stays in the next picture, 0..1; 0: none"
    )

    def __post_init__(self) -> None:
        """Refuse what no detector can work with."""
        if self.provider not in PROVIDERS:
            raise SettingsError(f"provider must be one of {', '.join(PROVIDERS)}, got {self.provider!r}")
        if self.threads < 1:
            raise SettingsError(f"threads must be at least 1, got {self.threads}")
        if self.size < 0 or self.size % STRIDE:
            raise SettingsError(
                f"size must be a multiple of {STRIDE} px or 0 for the model's own, got {self.size}"
            )
        for name in ("score_threshold", "overlap_limit", "smoothing"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise SettingsError(f"{name} must lie in 0..1, got {value}")
        if self.smoothing > 0.95:
            raise SettingsError(
                f"smoothing must be 0.95 or less, or boxes never arrive; got {self.smoothing}"
            )
        if self.most_regions < 1:
            raise SettingsError(f"most_regions must be at least 1, got {self.most_regions}")
