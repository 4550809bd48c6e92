"""What the localiser remembers between pictures: cameras, frames, the chosen region, its recent targets."""

import threading

import numpy as np
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.geometry.frame_tree import FrameTree, UnknownFrameError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse
from bathbot_depthcorr.ros.verdict import Level, Verdict
from numpy.typing import NDArray

from bathbot_localize.arm.arm_shape import ArmShape
from bathbot_localize.errors import LocalizeError
from bathbot_localize.regions import SkinRegion
from bathbot_localize.surface.disc import NoSkinError
from bathbot_localize.target.body_cloud import BodyCloud, Known
from bathbot_localize.target.localizer import Frame, Localised, locate_all, make_frame, surface_of
from bathbot_localize.target.roi_memory import RoiMemory
from bathbot_localize.target.smoothing import TargetSmoother
from bathbot_localize.target_localizer_settings import TargetLocalizerSettings

Array = NDArray[np.float64]
_SKEW = 0.05  # [s] that a picture's stamp and those of the joint angles may be apart


class UnknownRegionError(LocalizeError):
    """A name that is no class of the detector."""


class LocalizerSession:
    """Turns depth pictures and regions into targets and surfaces; several threads may use it.

    Attributes:
        problems: What goes wrong and why, by the name of an input or output, until it goes well.
        placed: Whether the camera's place in the base frame has been told.
    """

    def __init__(self, settings: TargetLocalizerSettings, T_base_colour: Array, shape: ArmShape) -> None:
        """Begin with a hand-eye result and an arm, and nothing known of the cameras."""
        self.settings, self.T_base_colour = settings, T_base_colour
        self._shape, self._link_names = shape, shape.links
        self.names = tuple(settings.region_names)
        self.colour_camera: Pinhole | None = None
        self.depth_camera: Pinhole | None = None
        self.T_colour_depth: Array | None = None
        self.problems: dict[str, str] = {}
        self.placed = False
        self._frames, self._frames_lock = FrameTree(), threading.Lock()
        self._arm_known = False
        self._body = BodyCloud(settings.cloud_voxel, settings.cloud_memory, settings.arm_margin)
        self._body_problem = ""
        self._smoothers: dict[str, TargetSmoother] = {}
        self._looked: Localised | None = None
        self._surface_problem = ""
        self._last_regions = self._last_depth = -np.inf
        self.select(settings.region)

    @property
    def region(self) -> str:
        """Name of the chosen region."""
        return self._memory.name

    @property
    def roi(self) -> SkinRegion | None:
        """Where the chosen region is measured now; None while it is not found."""
        return self._roi

    @property
    def sees_body(self) -> bool:
        """Whether a cloud of the body can be had: cameras known, and the arm, to be left out of it."""
        return self._arm_known and not self.missing()

    def select(self, region: str) -> None:
        """Choose another region.

        Raises:
            UnknownRegionError: When the detector has no such class.
        """
        if region not in self.names:
            raise UnknownRegionError(f"region {region!r} is none of {', '.join(self.names)}")
        self._memory = RoiMemory(region, self.settings.region_patience)
        self._roi: SkinRegion | None = None
        self._surface_problem = ""

    def meet_colour_camera(self, camera: Pinhole) -> None:
        """Take note of the colour camera."""
        self.colour_camera = camera

    def meet_depth_camera(self, camera: Pinhole) -> None:
        """Take note of the camera of corrected depth."""
        self.depth_camera = camera

    def meet_extrinsics(self, T_colour_depth: Array) -> None:
        """Take note of where the depth camera stands, shape (4, 4)."""
        self.T_colour_depth = T_colour_depth

    def add_transform(self, parent: str, child: str, transform: Array, stamp: float | None) -> None:
        """Take in one entry of /tf, or of /tf_static with `stamp` None."""
        with self._frames_lock:
            self._frames.add(parent, child, transform, stamp)
            self._arm_known |= child == self._link_names[-1]

    def T_base_camera_link(self) -> Array:
        """Pose of the camera's body in the base frame, shape (4, 4).

        Raises:
            UnknownFrameError: Until the camera's static transforms have come.
        """
        with self._frames_lock:
            T_link_colour = self._frames.lookup(self.settings.camera_frame, self.settings.colour_frame)
        return self.T_base_colour @ inverse(T_link_colour)

    def place(self) -> Array | None:
        """Pose of the camera's body in the base frame, shape (4, 4), once: when it is first known."""
        if self.placed:
            return None
        try:
            transform = self.T_base_camera_link()
        except UnknownFrameError:
            return None  # the verdict tells
        self.placed = True
        return transform

    def fail(self, name: str, error: Exception) -> None:
        """Remember why an input or output of this name goes wrong, until `solve`."""
        told = isinstance(error, BathbotError)
        self.problems[name] = str(error) if told else f"{type(error).__name__}: {error}"

    def solve(self, name: str) -> None:
        """Forget what went wrong: it goes well."""
        self.problems.pop(name, None)

    def missing(self) -> list[str]:
        """What has not come yet and is needed before anything can be located."""
        parts = {
            "colour camera_info": self.colour_camera,
            "corrected depth's camera_info": self.depth_camera,
            "depth_to_color extrinsics": self.T_colour_depth,
        }
        return [name for name, value in parts.items() if value is None]

    def locate(self, depth: NDArray[np.float32], stamp: float, regions: list[SkinRegion]) -> Localised:
        """Targets of all regions; also decides where the chosen region is measured from now on.

        Raises:
            LocalizeError: When the pictures do not fit together or the arm's pose is not known.
        """
        frame = self._frame(depth, stamp)
        usable = [region for region in regions if region.score >= self.settings.min_score]
        looked = locate_all(frame, usable, self.settings)
        chosen = [region for region in usable if region.name == self.region]
        target = [target for target in looked.targets if target.region == self.region]
        self._roi = self._memory.update(
            _under(chosen, target[0].pixel if target else None), frame.silhouette, stamp
        )
        noise_free = np.eye(3) * self.settings.systematic**2
        smooth = [
            self._smoothers.setdefault(target.region, TargetSmoother(self.settings.smoothing_frames)).update(
                target, stamp, target.covariance[:3, :3] - noise_free
            )
            for target in looked.targets
        ]
        self._looked = Localised(smooth, looked.refused)
        return self._looked

    def surface(self, depth: NDArray[np.float32], stamp: float) -> Array:
        """Surface of the chosen region in the base frame [m], shape (h, w, 3), NaN where unknown.

        Raises:
            LocalizeError: When the region is not found, holds no depth, or the arm's pose is not known.
        """
        roi = self._roi
        if roi is None:
            raise NoSkinError(f"region {self.region} is not found")
        try:
            points = surface_of(self._frame(depth, stamp), roi.box, self.settings)
        except LocalizeError as error:
            self._surface_problem = str(error)
            raise
        self._surface_problem = ""
        return points

    def body(self, depth: NDArray[np.float32], stamp: float) -> Known:
        """Coarse cloud of all that is seen or was, but for the arm.

        Only one thread may ask. A picture that does not show what it should is a problem until one does.

        Raises:
            LocalizeError: When the arm's pose at that time is not known.
        """
        beside = [self._links(stamp + skew) for skew in (-_SKEW, _SKEW)]
        known = self._body.update(self._frame(depth, stamp), stamp, beside)
        self._body_problem = ""
        if known.stamp < stamp:
            when = "ever" if np.isinf(known.stamp) else f"for {stamp - known.stamp:.1f} s"
            self._body_problem = (
                f"the body is not seen {when}: no depth at {known.unseen:.0%} of the places where something "
                "stood, or hidden by the arm for too long; is the lens free?"
            )
        return known

    def seen(self, now: float, depth: bool = False, regions: bool = False) -> None:
        """Note the time [s] at which a depth picture or a list of regions came."""
        self._last_depth = now if depth else self._last_depth
        self._last_regions = now if regions else self._last_regions

    def verdict(self, now: float) -> Verdict:
        """How things stand at time `now` [s]; the first thing that is wrong is named."""
        if trouble := self._trouble(now):
            return Verdict(Level.WARN, trouble)
        if problems := dict(self.problems):
            return Verdict(Level.ERROR, "; ".join(f"{name}: {why}" for name, why in problems.items()))
        if not self.placed:
            return Verdict(
                Level.WARN, "no static transforms of the camera; does its driver publish /tf_static?"
            )
        unmasked = "" if self._arm_known else "; the arm is not masked: no transforms of it have come"
        return Verdict(Level.OK, f"{self.region} is located{unmasked}")

    def _trouble(self, now: float) -> str:
        """What does not come, or is not found; empty when all is there."""
        limit = self.settings.max_depth_age
        if self.missing():
            return f"waiting for {', '.join(self.missing())}; does the camera run?"
        if not now - self._last_depth <= limit:
            return f"no corrected depth {_since(now - self._last_depth)}; does depth_corrector run?"
        if not now - self._last_regions <= 5.0 * limit:
            return f"no skin regions {_since(now - self._last_regions)}; does skin_detector run?"
        if self._body_problem:
            return self._body_problem
        if self._looked is not None and self.region in self._looked.refused:
            return f"{self.region}: {self._looked.refused[self.region]}"
        if self._roi is None:
            found = ", ".join(target.region for target in self._looked.targets) if self._looked else ""
            return f"region {self.region} is not found; found are {found or 'none'}"
        if self._surface_problem:
            return f"{self.region}: {self._surface_problem}"
        return ""

    def _frame(self, depth: NDArray[np.float32], stamp: float) -> Frame:
        if self.missing():
            raise LocalizeError(f"waiting for {', '.join(self.missing())}; does the camera run?")
        return make_frame(
            depth, self.depth_camera, self.colour_camera, self.T_colour_depth, self.T_base_colour,
            self._shape, self._links(stamp), self.settings.arm_margin,
        )  # fmt: skip

    def _links(self, stamp: float) -> dict[str, Array]:
        """Pose of each link of the arm at a time; empty when no arm has ever been heard of."""
        with self._frames_lock:
            if not self._arm_known:
                return {}
            try:
                return {
                    link: self._frames.lookup(self.settings.base_frame, link, stamp)
                    for link in self._link_names
                }
            except UnknownFrameError as error:
                raise LocalizeError(f"the arm cannot be masked: {error}") from error


def _under(regions: list[SkinRegion], pixel: tuple[float, float] | None) -> SkinRegion | None:
    """The region that the target was found in, else the best one."""
    if pixel is not None:
        regions = [
            r
            for r in regions
            if r.box[0] <= pixel[0] + 0.5 <= r.box[2] and r.box[1] <= pixel[1] + 0.5 <= r.box[3]
        ] or regions
    return max(regions, key=lambda region: region.score, default=None)


def _since(age: float) -> str:
    return f"for {age:.1f} s" if np.isfinite(age) else "yet"
