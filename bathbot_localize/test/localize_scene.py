"""An analytic scene for tests: spheres, cylinders, planes, seen by a pair of cameras like a D455's."""

import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, rotate, transform_from, transform_points
from bathbot_localize.surface.registration import picture_rays
from scipy.spatial.transform import Rotation

DEPTH = Pinhole(424, 240, 212.0, 212.0, 211.6, 120.4)
COLOUR = Pinhole(424, 240, 209.5, 209.3, 212.2, 119.8, (-0.0565, 0.0688, -0.00072, -0.00002, -0.0224))
T_COLOUR_DEPTH = transform_from(
    Rotation.from_rotvec([0.002, -0.003, 0.001]).as_matrix(), (-0.059, 0.0003, 0.0002)
)
FB = 212.0 * 0.095  # focal length times baseline [px m] of the depth camera

# The camera hangs on a mast beside the base and looks at a point in front of it.
_EYE, _LOOK_AT = np.array([-0.12, 0.35, 0.62]), np.array([0.50, 0.0, 0.25])
_Z = (_LOOK_AT - _EYE) / np.linalg.norm(_LOOK_AT - _EYE)
_X = np.cross(_Z, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(_Z, [0.0, 0.0, 1.0]))
T_BASE_COLOUR = transform_from(np.column_stack([_X, np.cross(_Z, _X), _Z]), _EYE)
T_BASE_DEPTH = T_BASE_COLOUR @ T_COLOUR_DEPTH


def sphere(centre, radius):
    """Shares of rays, shape (...), from an origin to a sphere, in one frame; NaN where they miss."""

    def cast(origin, rays):
        length = np.linalg.norm(rays, axis=-1)
        unit = rays / length[..., None]
        offset = origin - np.asarray(centre)
        b = unit @ offset
        root = b * b - (offset @ offset - radius**2)
        with np.errstate(invalid="ignore"):
            return (-b - np.sqrt(root)) / length

    return cast


def cylinder(point, axis, radius):
    axis = np.asarray(axis) / np.linalg.norm(axis)

    def cast(origin, rays):
        flat = rays - (rays @ axis)[..., None] * axis
        offset = origin - np.asarray(point)
        offset = offset - (offset @ axis) * axis
        a, b, c = (flat * flat).sum(-1), flat @ offset, offset @ offset - radius**2
        with np.errstate(invalid="ignore", divide="ignore"):
            return (-b - np.sqrt(b * b - a * c)) / a

    return cast


def rod(start, end, radius):
    """A capsule: a cylinder between two points with half spheres at its ends."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    side, caps = cylinder(start, end - start, radius), (sphere(start, radius), sphere(end, radius))

    def cast(origin, rays):
        share = side(origin, rays)
        place = (origin + share[..., None] * rays - start) @ (end - start) / ((end - start) @ (end - start))
        shares = [np.where((place >= 0.0) & (place <= 1.0), share, np.inf)]
        shares += [np.nan_to_num(cap(origin, rays), nan=np.inf) for cap in caps]
        nearest = np.min(shares, axis=0)
        return np.where(np.isfinite(nearest), nearest, np.nan)

    return cast


def plane(point, normal):
    normal = np.asarray(normal) / np.linalg.norm(normal)

    def cast(origin, rays):
        with np.errstate(divide="ignore"):
            share = (np.asarray(point) - origin) @ normal / (rays @ normal)
        return np.where(share > 0.0, share, np.nan)

    return cast


def render(*shapes, T_base_depth=T_BASE_DEPTH, camera=DEPTH):
    """Depth [m], shape (H, W), of shapes given in the base frame, float32."""
    rays = picture_rays(camera)
    cast = [shape(T_base_depth[:3, 3], rotate(T_base_depth, rays)) for shape in shapes]
    cast = np.stack([np.where(share > 0.0, share, np.nan) for share in cast])
    nearest = np.where(np.isnan(cast), np.inf, cast).min(axis=0)
    return np.where(np.isfinite(nearest), nearest, np.nan).astype(np.float32)


def hit(shape, pixel, T_base_colour=T_BASE_COLOUR, camera=COLOUR):
    """Point of a shape [m], base frame, on the ray of a colour pixel."""
    ray = rotate(T_base_colour, camera.directions(np.asarray(pixel, dtype=float)))
    return T_base_colour[:3, 3] + shape(T_base_colour[:3, 3], ray) * ray


def pixel_of(point, T_base_colour=T_BASE_COLOUR, camera=COLOUR):
    """Colour pixel (u, v) of a point in the base frame [m]."""
    return camera.project(transform_points(inverse(T_base_colour), point))


def with_noise(depth, rng, sigma_px=0.07, outliers=0.0):
    """Depth with disparity noise [px], and with a share of outliers of 2 to 10 px."""
    disparity = FB / depth + rng.normal(0.0, sigma_px, depth.shape)
    wild = rng.random(depth.shape) < outliers
    disparity[wild] += rng.uniform(2.0, 10.0, wild.sum()) * rng.choice([-1.0, 1.0], wild.sum())
    return (FB / np.maximum(disparity, 1.0)).astype(np.float32)


def box_around(pixel, half):
    """Box (left, top, right, bottom) [px] whose middle is a pixel."""
    u, v = np.asarray(pixel) + 0.5
    return (u - half, v - half, u + half, v + half)
