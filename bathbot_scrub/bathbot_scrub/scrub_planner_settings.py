"""What a user may change of the scrub planner; `config/scrub_planner.yaml` has these keys."""

from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, setting
from bathbot_localize.arm.scrub_head import SCRUB_HEAD

from bathbot_scrub.errors import SettingsError
from bathbot_scrub.segment.segment import MOST_POSES


@dataclass(frozen=True, slots=True)
class ScrubPlannerSettings:
    """Parameters of the scrub planner, SI units unless the name says otherwise."""

    patch_length: float = setting(
        0.14, "Length of the patch washed, along the scan lines, measured on the skin", "m", above=0.0
    )
    patch_width: float = setting(
        0.12, "Width of the patch washed, across the scan lines, measured on the skin", "m", above=0.0
    )
    brush_diameter: float = setting(
        2.0 * SCRUB_HEAD.brush_radius, "Width of the skin that one scan line washes", "m", above=0.0
    )
    line_spacing: float = setting(
        0.8, "Distance between neighbouring scan lines, as a multiple of brush_diameter", above=0.0
    )
    edge_margin: float = setting(
        0.012, "Distance that the middle of the brush keeps from the edge of the skin seen", "m", low=0.0,
        high=0.05,
    )  # fmt: skip
    head_room: float = setting(
        0.035, "Radius of the space over the brush that must be empty for the scrub head", "m", low=0.0,
        high=0.1,
    )  # fmt: skip
    max_relief: float = setting(
        0.012, "Height over the skin above which what is beside the brush counts as an obstacle", "m",
        above=0.0,
    )  # fmt: skip
    max_slope_deg: float = setting(
        60.0, "Largest angle between the skin's normal along the path and the normal of the contact target",
        "deg", low=5.0, high=80.0,
    )  # fmt: skip
    depth_jump: float = setting(
        0.012, "Step in height between neighbouring pixels of the surface at which the skin ends", "m",
        above=0.0,
    )  # fmt: skip
    cell: float = setting(0.004, "Side of a square cell of the surface map", "m", low=0.001, high=0.01)
    smoothing: float = setting(
        0.010, "Width of the local fit that smooths the surface, as the standard deviation of its weights",
        "m", above=0.0,
    )  # fmt: skip
    map_margin: float = setting(
        0.06, "Width of the strip of skin around the patch in which the skin's motion is watched too", "m",
        low=0.0, high=0.2,
    )  # fmt: skip

    step: float = setting(0.002, "Distance between neighbouring poses of a scrub path", "m", above=0.0)
    compression: float = setting(
        0.005, "Depth by which the path presses the bristles into the skin, at most what they give", "m",
        low=0.0, high=SCRUB_HEAD.give,
    )  # fmt: skip
    max_bend: float = setting(
        0.0075, "Largest bend of the bristles beside the middle of the brush; so a hollow is pressed less",
        "m", low=0.001, high=SCRUB_HEAD.give,
    )  # fmt: skip
    turn_threshold_deg: float = setting(
        6.0, "Turn of the skin's normal against the last pose applied, from which the brush is turned too: "
        "theta of Eq. (18)", "deg", above=0.0,
    )  # fmt: skip
    segment_points: int = setting(
        30, "Number of poses in one segment of a scrub path", low=5, high=MOST_POSES
    )
    ahead: int = setting(
        3, "Number of segments kept with the arm, the one under the scrub head included", low=1
    )
    speed: float = setting(0.04, "Speed of the scrub head along the path", "m/s", above=0.0)
    blend: float = setting(
        0.02, "Length of path over which a segment passes from the surface planned on before to the new "
        "one", "m", above=0.0,
    )  # fmt: skip

    surface_max_age: float = setting(
        60.0, "Largest age of the surface that a path is planned on, which is seen before the arm comes", "s",
        low=1.0, high=120.0,
    )  # fmt: skip
    body_max_age: float = setting(
        5.0, "Age of the newest body_cloud above which no path is chosen", "s", low=0.5, high=10.0
    )
    lost_after: float = setting(
        3.0,
        "Time without skin in sight around the arm after which the target counts as lost",
        "s",
        low=0.5,
        high=10.0,
    )
    breath_window: float = setting(
        6.0, "Length of time whose mean height of the breathing skin is planned on", "s", above=0.0
    )
    breath_range: float = setting(
        0.004, "Distance of the skin from its mean height beyond which it has moved for good", "m", above=0.0
    )
    max_shift: float = setting(
        0.02, "Largest motion of the skin along its normal, since the arm came, that a path follows", "m",
        low=0.002, high=0.03,
    )  # fmt: skip
    min_cells: int = setting(
        40, "Number of map cells with skin in sight below which its motion cannot be told", low=1
    )
    watch_period: float = setting(
        0.05, "Time between two looks at the clock while no new surface comes", "s", above=0.0
    )
    max_offset: float = setting(
        0.03, "Largest distance between the scrub head in contact and the contact target", "m", above=0.0
    )

    force_limits: str = setting(
        "", "YAML file of force limits for each region of the body; empty: config/force_limits.yaml"
    )
    min_reach: float = setting(
        0.4, "Share of the patch that must lie within the arm's reach, 0..1", low=0.0, high=1.0
    )
    arm_variant: str = setting(
        "6F", "Variant of the RM65, which decides the arm's reach: B, 6F (force sensor as extra part) or "
        "6FB (force sensor built in)",
    )  # fmt: skip
    reach_margin: float = setting(
        0.01, "Distance by which the skin may move along its normal and still be within the arm's reach", "m",
        low=0.0, high=0.05,
    )  # fmt: skip
    arm_state_max_age: float = setting(
        0.5, "Age of the newest arm_state above which the arm counts as silent", "s", above=0.0
    )
    stall_timeout: float = setting(
        5.0, "Time within which the arm must take up the path, or move on along it", "s", above=0.0
    )

    def __post_init__(self) -> None:
        """Refuse values that plan no path.

        Raises:
            SettingsError: With the value and what is allowed.
        """
        check(self, SettingsError)
