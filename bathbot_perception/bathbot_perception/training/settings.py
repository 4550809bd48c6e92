"""What a user may change about a training run."""

import math
from dataclasses import dataclass

from bathbot_perception.errors import SettingsError

_SMALLEST = 96  # [px]; on a map of 2x1 cells torch's bfloat16 convolutions give numbers that are none
OPTIMISERS = ("adamw", "sgd")


@dataclass(frozen=True, slots=True)
class TrainSettings:
    """What a user may change about a run."""

    minutes: float = 90.0
    """Budget of training time, without validation."""
    long_side: int = 640
    """Longer side of whole pictures in training [px]."""
    batch: int = 12
    optimiser: str = "adamw"
    """adamw, or sgd as in the paper: there with rate 0.001 and decay 0.01."""
    rate: float = 1e-3
    """Learning rate after warm-up."""
    rate_end: float = 0.03
    """Share of it that is left at the end."""
    decay: float = 0.02
    warmup: int = 300
    """Steps of warm-up."""
    mosaic: float = 0.6
    mosaic_until: float = 0.85
    """Share of the budget after which only whole pictures are shown."""
    anchor_scales: tuple[float, ...] = (1.0, 3.0)
    """Magnifications at which boxes are clustered, so that anchors also fit people close to the camera."""
    freeze_until: float = 0.0
    """Share of the budget with a frozen backbone (for fine-tuning)."""
    shares: tuple[float, ...] = ()
    """Chance of each data set; empty means by size."""
    validate_minutes: float = 6.0
    checkpoint_minutes: float = 3.0
    threads: int = 2
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse what cannot be trained with."""
        if not 0.0 <= self.freeze_until < 1.0:
            raise SettingsError(f"freeze_until must lie in 0..1, got {self.freeze_until}")
        if self.optimiser not in OPTIMISERS:
            raise SettingsError(f"optimiser must be {' or '.join(OPTIMISERS)}, got {self.optimiser!r}")
        if self.long_side % 32 or self.long_side < _SMALLEST:
            raise SettingsError(
                f"long_side must be a multiple of 32 px from {_SMALLEST} on, got {self.long_side}"
            )
        if not (self.minutes > 0 and self.batch > 0 and self.rate > 0):
            raise SettingsError(
                f"minutes, batch and rate must be positive, got {self.minutes}, {self.batch}, {self.rate}"
            )


def rate_at(step: int, share: float, settings: TrainSettings) -> float:
    """Learning rate after `step` steps and a share of the budget in [0, 1]."""
    cosine = settings.rate_end + (1 - settings.rate_end) * (1 + math.cos(math.pi * min(share, 1.0))) / 2
    return settings.rate * min((step + 1) / settings.warmup, 1.0) * cosine
