"""Parameters of the node target_localizer; config/target_localizer.yaml has these keys."""

from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, setting

from bathbot_localize.errors import SettingsError


@dataclass(frozen=True, slots=True)
class TargetLocalizerSettings:
    """What a user may change."""

    hand_eye: str = setting(
        "", "File written by `bathbot calibrate hand-eye`, which holds the pose of the camera in the base "
        "frame",
    )  # fmt: skip
    region: str = setting(
        "Trunk_skin", "Class name of the region whose surface is published until select_region names another"
    )
    region_names: tuple[str, ...] = setting(
        ("Face_skin", "Trunk_skin", "Upperlimb_skin", "Lowerlimb_skin", "Hand_skin", "Foot_skin"),
        "Class names that select_region accepts until the detector publishes its own list",
    )  # fmt: skip
    min_score: float = setting(
        0.3, "Confidence, 0..1, below which a detection is left out", low=0.0, high=1.0
    )
    disc_radius_px: float = setting(
        16.0, "Radius, in the colour picture, of the disc of skin that gives a target's position and "
        "normal (Fig. 5); for pictures 848 px wide", "px", above=0.0,
    )  # fmt: skip
    noise_correlation_px: float = setting(
        2.5, "Blur of the depth noise, as the standard deviation of a Gaussian; neighbouring pixels that "
        "share noise count as fewer", "px", low=0.0,
    )  # fmt: skip
    max_roughness: float = setting(
        0.008, "Largest scatter of points around the surface fitted to them that still makes a target", "m",
        above=0.0,
    )  # fmt: skip
    max_uncertainty: float = setting(
        0.004, "Largest standard deviation of a target's position; one less certain is not told", "m",
        above=0.0,
    )  # fmt: skip
    head_room: float = setting(
        0.045, "Radius of the space over a target that must be empty for the scrub head", "m", low=0.0
    )
    max_relief: float = setting(
        0.010, "Height over a target's surface above which what is beside it counts as an obstacle", "m",
        above=0.0,
    )  # fmt: skip
    systematic: float = setting(
        0.0008, "Error of positions that does not average out, added to the covariance of a target as a "
        "standard deviation", "m", low=0.0,
    )  # fmt: skip
    smoothing_frames: int = setting(5, "Number of frames averaged for one target; 1: no averaging", low=1)
    surface_stride: int = setting(
        2, "Distance between the colour pixels of a region that become points of its surface; 1: every "
        "pixel", "px", low=1,
    )  # fmt: skip
    surface_window: int = setting(
        3, "Side of the square of points over which each point of the surface is averaged, odd; 1: no "
        "averaging", low=1, step=2,
    )  # fmt: skip
    surface_rate: float = setting(10.0, "Highest rate at which surfaces are published", "Hz", above=0.0)
    cloud_rate: float = setting(1.0, "Highest rate at which body clouds are published", "Hz", above=0.0)
    cloud_voxel: float = setting(
        0.02,
        "Edge of the cubes of space each of which becomes one point of the body cloud",
        "m",
        low=0.005,
        high=0.03,
    )
    cloud_memory: float = setting(
        120.0,
        "Time for which places hidden by the arm count as seen; hidden for longer they stay in the "
        "body cloud, which counts as old then",
        "s",
        low=10.0,
        high=300.0,
    )
    region_margin_px: float = setting(
        10.0, "Width added around the box of a region on all sides before its surface is taken", "px", low=0.0
    )
    arm_margin: float = setting(
        0.02, "Distance by which the arm is masked out of the depth picture wider than it is", "m", low=0.0
    )
    region_patience: float = setting(
        1.0, "Time for which a region lost without the arm in the way is kept", "s", low=0.0
    )
    max_stamp_difference: float = setting(
        0.05, "Largest difference between the stamps of a region's picture and the depth picture it is met "
        "with", "s", above=0.0,
    )  # fmt: skip
    max_depth_age: float = setting(
        1.0, "Time without a depth picture after which the node warns", "s", above=0.0
    )
    depth_history: int = setting(
        45, "Number of depth pictures kept for regions that arrive later than they", low=1
    )
    base_frame: str = setting(
        "base_link", "TF frame of the robot's base, in which targets and surfaces are told"
    )
    camera_frame: str = setting(
        "camera_link", "TF frame of the camera's body, to which the static transform from the base is "
        "published",
    )  # fmt: skip
    colour_frame: str = setting(
        "camera_color_optical_frame", "TF frame of the colour picture, whose pose the hand-eye result holds"
    )

    def __post_init__(self) -> None:
        """Refuse values that cannot be meant.

        Raises:
            SettingsError: With the value and what is allowed.
        """
        check(self, SettingsError)
        if self.region not in self.region_names:
            raise SettingsError(f"region {self.region!r} is none of {', '.join(self.region_names)}")
