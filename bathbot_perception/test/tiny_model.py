"""What the tiny models of conftest.py answer."""

from bathbot_perception.classes import SKIN_CLASSES


def row(name: str, score: float, centre: tuple[float, float], size: tuple[float, float]) -> list[float]:
    """One raw prediction [px of the input] with objectness 1."""
    return [*centre, *size, 1.0, *(score if name == other else 0.0 for other in SKIN_CLASSES)]
