"""From one pair of pictures to contact targets and to the surface of a region, in the base frame."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import transform_from, transform_points
from numpy.typing import NDArray

from bathbot_localize.arm import clearance
from bathbot_localize.arm.arm_mask import arm_silhouette, near_arm
from bathbot_localize.arm.arm_shape import ArmCapsule, ArmShape
from bathbot_localize.arm.clearance import Column, has_room
from bathbot_localize.errors import LocalizeError
from bathbot_localize.regions import SkinRegion
from bathbot_localize.surface.disc import Disc, NoSkinError, candidate_discs
from bathbot_localize.surface.registration import Patch, register
from bathbot_localize.surface.skin_layer import away_from_edges, skin_layer
from bathbot_localize.surface.surface_fit import DegenerateSurfaceError, fit_surface
from bathbot_localize.surface.surface_smoothing import smooth_inverse_depth
from bathbot_localize.surface.workspace import Workspace, outward_normals
from bathbot_localize.target.target import Target, target_from_fit
from bathbot_localize.target_localizer_settings import TargetLocalizerSettings

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_SURROUNDINGS = 3.0  # side of what must be workable about a target, in radii of its disc
_CHOICE_STRIDE = 2  # [px] the target pixel is chosen on a grid this coarse
_LEAST_AGREEMENT = 0.6  # share of a disc's points that must lie on the fitted surface
_WORTH = 0.5  # of several regions of one name, those with this share of the best score count


class RoughSurfaceError(LocalizeError):
    """A disc whose points lie on no smooth surface, or leave its place in doubt."""


class Frame(NamedTuple):
    """What the localiser knows of one moment.

    Attributes:
        depth: Corrected depth [m], shape (H, W), NaN = none.
        T_colour_depth: Maps depth to colour camera coordinates, shape (4, 4).
        T_base_colour: Maps colour camera to base coordinates, shape (4, 4); hand-eye.
        shape: Of the arm.
        T_base_link: Pose of each link of the arm by name; empty where there is no arm.
        silhouette: Pixels of the colour picture that the arm covers, shape (H, W).
    """

    depth: NDArray[np.float32]
    depth_camera: Pinhole
    colour_camera: Pinhole
    T_colour_depth: Array
    T_base_colour: Array
    shape: ArmShape
    T_base_link: Mapping[str, Array]
    silhouette: NDArray[np.bool_]


class Localised(NamedTuple):
    """Targets of one frame, and for each region without one the reason in plain words."""

    targets: list[Target]
    refused: dict[str, str]


def make_frame(
    depth: NDArray[np.float32], depth_camera: Pinhole, colour_camera: Pinhole, T_colour_depth: Array,
    T_base_colour: Array, shape: ArmShape, T_base_link: Mapping[str, Array], arm_margin: float = 0.02,
) -> Frame:  # fmt: skip
    """A frame with the arm's silhouette drawn; see `Frame` for the arguments."""
    silhouette = arm_silhouette(shape.capsules, T_base_link, T_base_colour, colour_camera, arm_margin)
    return Frame(
        depth, depth_camera, colour_camera, T_colour_depth, T_base_colour, shape, T_base_link, silhouette
    )


def register_skin(frame: Frame, box: tuple[float, ...], stride: int, arm_margin: float) -> Patch:
    """Points of a box that belong to neither the arm nor anything it covers; the rest is NaN."""
    patch = register(frame.depth, frame.depth_camera, frame.T_colour_depth, frame.colour_camera, box, stride)
    points = patch.points
    points[frame.silhouette[np.ix_(patch.v.astype(int), patch.u.astype(int))]] = np.nan
    if frame.T_base_link:
        seen = transform_points(frame.T_base_colour, points)
        points[near_arm(seen, frame.shape.capsules, frame.T_base_link, arm_margin)] = np.nan
    return patch


def locate(frame: Frame, region: SkinRegion, settings: TargetLocalizerSettings) -> Target:
    """The contact target of a region: the middle of its box, or the nearest place with room for arm and head.

    Raises:
        LocalizeError: When the region has no place to touch; the message says why.
    """
    box = grown(region.box, settings.region_margin_px)
    patch = register_skin(frame, box, _CHOICE_STRIDE, settings.arm_margin)
    depth = patch.points[..., 2]
    skin = skin_layer(depth)
    layer = (depth[skin].min(), depth[skin].max()) if skin.any() else (np.nan, np.nan)
    flat = skin & away_from_edges(depth, _CHOICE_STRIDE)
    around = max(int(_SURROUNDINGS * settings.disc_radius_px / _CHOICE_STRIDE), 3)
    normals = outward_normals(patch.points)
    workable = flat & frame.shape.workspace.workable(patch.points, normals, frame.T_base_colour, around)
    roomy = flat & has_room(patch.points, normals, Column(settings.head_room, settings.max_relief))
    for places in [*filter(np.any, (workable & roomy, workable, roomy)), flat]:
        refusals = []
        for disc in _discs(places, patch, region, settings, refusals):
            try:
                return _target_of_disc(frame, region, disc, layer, settings)
            except (RoughSurfaceError, DegenerateSurfaceError) as error:
                refusals.append(error)
    raise refusals[0]


def _discs(
    places: Mask, patch: Patch, region: SkinRegion, settings: TargetLocalizerSettings, refusals: list
) -> Iterator[Disc]:
    """Discs to try, the best first; where there is none, the reason goes to `refusals`."""
    try:
        yield from candidate_discs(places, patch.u, patch.v, region.centre, settings.disc_radius_px)
    except NoSkinError as error:
        refusals.append(error)


def locate_all(frame: Frame, regions: list[SkinRegion], settings: TargetLocalizerSettings) -> Localised:
    """At most one target per name: of several regions the one nearest to the arm's base axis.

    Regions with less than half of the best score of their name do not count.
    """
    targets: dict[str, Target] = {}
    refused: dict[str, str] = {}
    for name in dict.fromkeys(region.name for region in regions):
        group = [region for region in regions if region.name == name]
        best = max(region.score for region in group)
        found = []
        for region in group:
            if region.score < max(_WORTH * best, settings.min_score):
                continue
            try:
                found.append(locate(frame, region, settings))
            except LocalizeError as error:
                refused[name] = str(error)
        if found:
            targets[name] = min(found, key=lambda target: float(np.hypot(*target.T_base_target[:2, 3])))
            refused.pop(name, None)
    return Localised(list(targets.values()), refused)


def surface_of(frame: Frame, box: tuple[float, ...], settings: TargetLocalizerSettings) -> Array:
    """Surface points of a box in the base frame [m], shape (h, w, 3), NaN where unknown or the arm.

    Raises:
        LocalizeError: When the box lies outside the picture or holds no skin.
    """
    wide = grown(box, settings.region_margin_px)
    patch = register_skin(frame, wide, settings.surface_stride, settings.arm_margin)
    layer = skin_layer(patch.points[..., 2])
    if not layer.any():
        raise NoSkinError(
            "no depth on skin in the region; is it hidden, too near, or out of the depth camera's view?"
        )
    points = np.where(layer[..., None], patch.points, np.nan)
    return transform_points(frame.T_base_colour, smooth_inverse_depth(points, settings.surface_window))


def warm_up() -> None:
    """Compile the loops, or load them from the cache of an earlier run, before the first picture comes."""
    camera = Pinhole(64, 48, 50.0, 50.0, 31.5, 23.5)
    depth = np.full((camera.height, camera.width), 0.7, np.float32)
    anywhere = Workspace((0.0, 0.0, 0.0), 0.0, np.inf, 0.0, np.inf)
    frame = make_frame(
        depth,
        camera,
        camera,
        np.eye(4),
        np.eye(4),
        ArmShape((ArmCapsule("arm", (0.0, 0.0, 0.0), (0.0, 0.0, 0.1), 0.05),), "arm", (), anywhere),
        {"arm": transform_from(translation=(9.0, 0.0, 1.0))},
    )
    surface_of(frame, (10.0, 10.0, 50.0, 40.0), TargetLocalizerSettings())
    clearance.warm_up()


def grown(box: tuple[float, ...], margin: float) -> tuple[float, float, float, float]:
    """A box with a margin [px] on all sides."""
    left, top, right, bottom = box
    return left - margin, top - margin, right + margin, bottom + margin


def _target_of_disc(
    frame: Frame,
    region: SkinRegion,
    disc: Disc,
    layer: tuple[float, float],
    settings: TargetLocalizerSettings,
) -> Target:
    (u, v), radius = disc
    box = (u - radius, v - radius, u + radius + 1.0, v + radius + 1.0)
    patch = register_skin(frame, box, 1, settings.arm_margin)
    inside = np.hypot(patch.u[None, :] - u, patch.v[:, None] - v) <= radius
    z = patch.points[..., 2]
    inside &= (z >= layer[0] - 0.02) & (z <= layer[1] + 0.02)
    direction = frame.colour_camera.directions(np.array([u, v]))
    blur = settings.noise_correlation_px * frame.colour_camera.fx / frame.depth_camera.fx
    # Interpolation between depth pixels spreads even white noise over two points.
    fit = fit_surface(patch.points[inside], direction, radius, 2.0 + 4.0 * np.pi * blur**2)
    if fit.inliers < _LEAST_AGREEMENT or not fit.scale <= settings.max_roughness or fit.parameters[0] <= 0.0:
        raise RoughSurfaceError(
            f"the points around the target scatter by {1e3 * fit.scale:.1f} mm and {fit.inliers:.0%} agree, "
            f"allowed are {1e3 * settings.max_roughness:.1f} mm and {_LEAST_AGREEMENT:.0%}; "
            "is an edge or an object there?"
        )
    pixel = float(u), float(v)
    target = target_from_fit(region.name, region.score, fit, frame.T_base_colour, pixel, settings.systematic)
    doubt = float(np.sqrt(np.trace(target.covariance[:3, :3])))
    if doubt > settings.max_uncertainty:
        raise RoughSurfaceError(
            f"the target's position is known to {1e3 * doubt:.1f} mm only, allowed are "
            f"{1e3 * settings.max_uncertainty:.1f} mm; is there too little depth, or an edge?"
        )
    return target
