"""Serial number and temperature of a RealSense, as its driver tells them on /diagnostics."""

from typing import Any, NamedTuple

STATUS_NAME = "Temperatures"  # realsense2_camera: "<node>: Temperatures", hardware_id = serial number
CHIP = "asic temperature"


class CameraHealth(NamedTuple):
    """Serial number, empty if unknown, and temperature of the depth chip [deg C], NaN if unknown."""

    serial: str = ""
    temperature: float = float("nan")


def camera_health(diagnostics: Any, known: CameraHealth = CameraHealth()) -> CameraHealth:
    """What a diagnostic_msgs/DiagnosticArray tells of the camera; `known` if it tells nothing."""
    for status in diagnostics.status:
        if not status.name.endswith(STATUS_NAME):
            continue
        temperature = known.temperature
        for entry in status.values:
            if entry.key.lower() == CHIP:
                temperature = _number(entry.value, temperature)
        return CameraHealth(status.hardware_id or known.serial, temperature)
    return known


def _number(text: str, otherwise: float) -> float:
    try:
        return float(text)
    except ValueError:
        return otherwise
