"""How the simulated calibrations are recorded, and what can be wrong with that."""

from dataclasses import dataclass

from bathbot_bringup.sim.calibration_scene import STEEPEST


@dataclass(frozen=True, slots=True)
class Recording:
    """One calibration's circumstances.

    Attributes:
        poses: Views of the board.
        frames: Depth frames averaged in each.
        steepest: Largest tilt of the board [rad].
        focal_error: Published focal length of the colour camera over the true one, minus 1, beyond what a
            usual unit has.
        square_error: Edge of the printed squares over the one that is told, minus 1.
        outliers: Share of depth pixels that a wrong match moved by 2 to 10 px.
    """

    poses: int = 24
    frames: int = 4
    steepest: float = STEEPEST
    focal_error: float = 0.0
    square_error: float = 0.0
    outliers: float = 0.0
