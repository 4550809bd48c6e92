"""What a user may change of the scrub planner; `config/scrub_planner.yaml` has these keys."""

from dataclasses import dataclass, field
from typing import Any

from bathbot_localize.arm.scrub_head import SCRUB_HEAD

from bathbot_scrub.errors import SettingsError


def _about(default: Any, text: str) -> Any:
    return field(default=default, metadata={"help": text})


@dataclass(frozen=True, slots=True)
class ScrubPlannerSettings:
    """Parameters of the scrub planner, SI units unless the name says otherwise."""

    patch_length: float = _about(0.14, "washed along the scan lines, measured on the skin [m]")
    patch_width: float = _about(0.12, "washed across the scan lines, measured on the skin [m]")
    brush_diameter: float = _about(2.0 * SCRUB_HEAD.brush_radius, "width of skin one scan line washes [m]")
    line_spacing: float = _about(0.8, "of scan lines, in brush diameters")
    edge_margin: float = _about(0.012, "between the middle of the brush and the edge of the skin seen [m]")
    head_room: float = _about(0.035, "radius of the space over the brush that must be empty [m]")
    max_relief: float = _about(0.012, "of what is beside the brush; higher is an obstacle [m]")
    max_slope_deg: float = _about(60.0, "between the skin's normal and that of the target [deg]")
    depth_jump: float = _about(0.012, "height step between neighbouring pixels that ends the skin [m]")
    cell: float = _about(0.004, "side of a cell of the surface map [m]")
    smoothing: float = _about(0.010, "standard deviation of the weights of the local fit [m]")
    map_margin: float = _about(0.06, "of skin around the patch in which motion is watched [m]")

    step: float = _about(0.002, "between neighbouring poses [m]")
    compression: float = _about(
        0.005, f"by which the path presses the bristles; they give {SCRUB_HEAD.give:.3f} [m]"
    )
    max_bend: float = _about(0.0075, "of bristles beside the middle; a hollow is pressed less [m]")
    turn_threshold_deg: float = _about(6.0, "theta of Eq. (18), against the last pose applied [deg]")
    segment_points: int = _about(30, "poses in one segment")
    ahead: int = _about(3, "segments kept with the arm, the one under the head included")
    speed: float = _about(0.04, "of the head along the path [m/s]")
    blend: float = _about(0.02, "of path over which a segment leaves the old surface for the new [m]")

    surface_max_age: float = _about(60.0, "of the surface seen before the arm came [s]")
    body_max_age: float = _about(5.0, "of body_cloud; with an older one no path is chosen [s]")
    lost_after: float = _about(3.0, "without skin in sight around the arm the target is lost [s]")
    breath_window: float = _about(6.0, "of which the mean height of the skin is planned on [s]")
    breath_range: float = _about(0.004, "from that mean; skin farther off has moved for good [m]")
    max_shift: float = _about(0.02, "of the skin along its normal since the arm came [m]")
    min_cells: int = _about(40, "cells of skin in sight, below which motion cannot be told")
    watch_period: float = _about(0.05, "between looks at the clock while no new surface comes [s]")
    max_offset: float = _about(0.03, "between the head in contact and the contact target [m]")

    force_limits: str = _about("", "file of force limits; empty: config/force_limits.yaml")
    min_reach: float = _about(0.4, "share of the patch that must lie within reach, 0..1")
    arm_variant: str = _about("6F", "of the RM65: B, 6F or 6FB; decides the reach")
    reach_margin: float = _about(0.01, "by which the skin may move along its normal and stay in reach [m]")
    arm_state_max_age: float = _about(0.5, "after which the arm counts as silent [s]")
    stall_timeout: float = _about(5.0, "for the arm to take up the path, or to move on along it [s]")

    def __post_init__(self) -> None:
        """Refuse values that plan no path."""
        self._demand_positive(
            "patch_length", "patch_width", "brush_diameter", "line_spacing", "depth_jump", "smoothing",
            "step", "max_relief", "breath_window", "breath_range",
            "turn_threshold_deg", "speed", "blend", "ahead", "surface_max_age", "lost_after", "body_max_age",
            "max_shift", "min_cells", "watch_period", "max_offset", "arm_state_max_age", "stall_timeout",
        )  # fmt: skip
        self._demand_within(
            ("edge_margin", 0.0, 0.05), ("map_margin", 0.0, 0.2), ("compression", 0.0, SCRUB_HEAD.give),
            ("max_bend", 0.001, SCRUB_HEAD.give),
            ("max_slope_deg", 5.0, 80.0), ("min_reach", 0.0, 1.0), ("reach_margin", 0.0, 0.05),
            ("head_room", 0.0, 0.1), ("cell", 0.001, 0.01), ("segment_points", 5, 500),
        )  # fmt: skip

    def _demand_positive(self, *names: str) -> None:
        for name in names:
            if not getattr(self, name) > 0:
                value = getattr(self, name)
                raise SettingsError(f"{name} must be positive, got {value}; see config/scrub_planner.yaml")

    def _demand_within(self, *limits: tuple[str, float, float]) -> None:
        for name, low, high in limits:
            if not low <= getattr(self, name) <= high:
                raise SettingsError(
                    f"{name} must lie between {low} and {high}, got {getattr(self, name)}; "
                    "see config/scrub_planner.yaml"
                )
