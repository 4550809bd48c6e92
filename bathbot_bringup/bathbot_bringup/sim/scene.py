"""The bathroom of one seed: who sits where, what the camera sees from where, what light there is.

base_link is the arm's base on a pedestal, z up, x towards the person. The person's front looks diagonally at
the arm, the legs pass beside the pedestal. Body, tone, pose and light vary with the seed; the camera does
not: it is one unit on one mast.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bathbot_bringup.sim.body import Body, body_count, load_body
from bathbot_bringup.sim.body_surface import BodySurface
from bathbot_bringup.sim.render.bathroom import clutter, random_lighting, random_room, stool
from bathbot_bringup.sim.render.mesh import Mesh, cylinder_shape, merged, plain_mesh
from bathbot_bringup.sim.render.stage import Stage, lit_stage, looking_at
from bathbot_bringup.sim.scenario import BodyMotion, Scenario
from bathbot_bringup.sim.skin_tone import Look, dressed, random_look

Array = NDArray[np.float64]

FLOOR = -0.75  # [m] below the arm's base
SEAT = (0.595, 0.01, -0.235)  # [m] where the pelvis rests
FACING_DEG = 137.0  # facing direction from +x: 43 deg away from the arm, legs towards +y
PEDESTAL_RADIUS = 0.06  # [m]
LEG_CLEARANCE = 0.025  # [m] between legs and pedestal
CAMERA_EYE = (-0.1183, 0.3322, 0.7417)  # [m] on the mast; not round, as no real mount is
CAMERA_TARGET = (0.452, 0.081, 0.214)  # [m]
CAMERA_ROLL_DEG = 0.7
T_LINK_OPTICAL = transform_from(
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
)  # camera_link -> optical axes
T_LINK_OPTICAL.setflags(write=False)


def true_camera_pose() -> Array:
    """T_base_camera of the depth camera's optical frame, shape (4, 4)."""
    return looking_at(CAMERA_EYE, CAMERA_TARGET, np.deg2rad(CAMERA_ROLL_DEG))


@dataclass(frozen=True)
class BathroomScene:
    """Everything in the bathroom that a seed decides."""

    seed: int

    @cached_property
    def body(self) -> Body:
        """The person, body frame; seeds 0, 1, 2, ... walk through the bodies."""
        return load_body(self.seed % body_count())

    @cached_property
    def look(self) -> Look:
        """Skin, hair and clothes."""
        return random_look(np.random.default_rng([self.seed, 11]), self.body.male)

    @cached_property
    def dressed(self) -> Mesh:
        """The person as seen and touched, body frame."""
        return dressed(self.body, self.look, np.random.default_rng([self.seed, 12]))

    @cached_property
    def T_base_body(self) -> Array:
        """Where the person sits: a few cm and degrees differ between seeds, and legs clear the pedestal."""
        rng = np.random.default_rng([self.seed, 13])
        turn = FACING_DEG + rng.uniform(-3.0, 3.0)
        seat = np.array(SEAT) + rng.uniform((-0.02, -0.02, -0.01), (0.02, 0.02, 0.01))
        low = self.body.vertices[self.body.vertices[:, 2] < -seat[2]]
        for extra in np.arange(0.0, 20.0, 1.0):
            rotation = Rotation.from_euler("z", turn - extra, degrees=True).as_matrix()
            placed = low @ rotation.T + seat
            if np.hypot(placed[:, 0], placed[:, 1]).min() > PEDESTAL_RADIUS + LEG_CLEARANCE:
                break
        return transform_from(rotation, seat)

    @property
    def T_base_camera(self) -> Array:
        """True pose of the depth camera's optical frame."""
        return true_camera_pose()

    @property
    def T_base_camera_link(self) -> Array:
        """True pose of camera_link, which sits at the depth camera with x forward, y left, z up."""
        return true_camera_pose() @ np.linalg.inv(T_LINK_OPTICAL)

    def surface(self, scenario: Scenario) -> BodySurface:
        """The moving skin of this person in a scenario."""
        return BodySurface(self.body, self.dressed, self.T_base_body, BodyMotion(scenario, self.seed))

    def stage(self) -> Stage:
        """The lit bathroom with the person at rest; the first vertices of its mesh are the person's."""
        rng = np.random.default_rng([self.seed, 14])
        room = random_room(rng, (-0.75, -1.1, FLOOR), (1.3, 1.3, 2.0))
        pedestal = cylinder_shape((0.0, 0.0, FLOOR), (0.0, 0.0, 0.0), (PEDESTAL_RADIUS, 0.055))
        seat = self.T_base_body[:3, 3]
        things = [
            self.dressed.placed(self.T_base_body),
            plain_mesh(*pedestal, (0.32, 0.33, 0.35), gloss=0.3),
            *stool(seat, FLOOR, rng),
            *clutter(rng, room),
        ]
        return lit_stage(merged(things), room, random_lighting(rng, room), rng)
