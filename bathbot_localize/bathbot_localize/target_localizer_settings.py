"""Parameters of the node target_localizer."""

from dataclasses import dataclass, field

from bathbot_localize.errors import SettingsError


def _setting(default: object, about: str) -> object:
    return field(default=default, metadata={"help": about})


@dataclass(frozen=True, slots=True)
class TargetLocalizerSettings:
    """What a user may change; config/target_localizer.yaml has these keys."""

    hand_eye: str = _setting(
        "", "file written by `bathbot calibrate hand-eye`: pose of the camera in the base"
    )
    region: str = _setting("Trunk_skin", "class name of the region whose surface is published at the start")
    region_names: tuple[str, ...] = _setting(
        ("Face_skin", "Trunk_skin", "Upperlimb_skin", "Lowerlimb_skin", "Hand_skin", "Foot_skin"),
        "names that select_region accepts until the detector publishes its own list",
    )
    min_score: float = _setting(0.3, "detections below this confidence are left out, 0..1")
    disc_radius_px: float = _setting(16.0, "radius of the disc that gives position and normal [px], Fig. 5")
    noise_correlation_px: float = _setting(
        2.5, "blur of the depth noise [px], standard deviation of a Gaussian"
    )
    max_roughness: float = _setting(0.008, "largest scatter of the points around the fitted surface [m]")
    max_uncertainty: float = _setting(0.004, "largest standard deviation of a target's position [m]")
    head_room: float = _setting(0.045, "radius of the space over a target that must be empty [m]")
    max_relief: float = _setting(0.010, "of what is beside a target; higher is an obstacle [m]")
    systematic: float = _setting(0.0008, "error that does not average out, added to the covariance [m]")
    smoothing_frames: int = _setting(5, "frames averaged for one target; 1 switches it off")
    surface_stride: int = _setting(
        2, "every how many-th colour pixel of the region becomes a surface point [px]"
    )
    surface_window: int = _setting(
        3, "surface points are averaged over this many points a side, odd; 1: not at all"
    )
    surface_rate: float = _setting(10.0, "surfaces published per second at most [Hz]")
    cloud_rate: float = _setting(1.0, "body clouds published per second at most [Hz]")
    cloud_voxel: float = _setting(0.02, "edge of the cells that become points of the body cloud [m]")
    cloud_memory: float = _setting(60.0, "places hidden by the arm stay in the body cloud this long [s]")
    region_margin_px: float = _setting(10.0, "added around a region's box on all sides [px]")
    arm_margin: float = _setting(0.02, "the arm is masked this much wider than it is [m]")
    region_patience: float = _setting(1.0, "a region lost without the arm in the way is kept this long [s]")
    max_stamp_difference: float = _setting(0.05, "between a region's picture and its depth picture [s]")
    max_depth_age: float = _setting(1.0, "a warning is given when no depth picture came for this long [s]")
    depth_history: int = _setting(45, "depth pictures kept for regions that arrive later")
    base_frame: str = _setting("base_link", "base of the robot")
    camera_frame: str = _setting(
        "camera_link", "body of the camera, which the static transform is published to"
    )
    colour_frame: str = _setting("camera_color_optical_frame", "frame of the colour picture")

    def __post_init__(self) -> None:
        """Refuse values that cannot be meant."""
        self._positive(
            "disc_radius_px",
            "max_roughness",
            "max_uncertainty",
            "max_relief",
            "surface_rate",
            "cloud_rate",
            "cloud_voxel",
            "max_stamp_difference",
            "max_depth_age",
        )
        for name in (
            "noise_correlation_px",
            "head_room",
            "systematic",
            "region_margin_px",
            "arm_margin",
            "region_patience",
            "cloud_memory",
        ):
            if not getattr(self, name) >= 0.0:
                raise SettingsError(f"{name} must not be negative, got {getattr(self, name)}")
        for name in ("smoothing_frames", "surface_stride", "surface_window", "depth_history"):
            if getattr(self, name) < 1:
                raise SettingsError(f"{name} must be at least 1, got {getattr(self, name)}")
        if self.surface_window % 2 == 0:
            raise SettingsError(f"surface_window must be odd, got {self.surface_window}")
        if not 0.0 <= self.min_score <= 1.0:
            raise SettingsError(f"min_score must lie in 0..1, got {self.min_score}")
        if self.region not in self.region_names:
            raise SettingsError(f"region {self.region!r} is none of {', '.join(self.region_names)}")

    def _positive(self, *names: str) -> None:
        for name in names:
            if not getattr(self, name) > 0.0:
                raise SettingsError(f"{name} must be positive, got {getattr(self, name)}")
