"""What the camera would see, frame after frame: colour and true depth of bathroom, person and arm.

What never moves is drawn once per camera; a frame draws the person and the arm over it.
"""

from dataclasses import replace
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.camera.arm_mesh import ArmMesh
from bathbot_bringup.sim.camera.d455_unit import D455Unit
from bathbot_bringup.sim.render.raster import project_vertices, rasterise
from bathbot_bringup.sim.render.render import Rendering, depth_of_room, developed, draw, picture_of_room
from bathbot_bringup.sim.render.weather import dropped, steamed
from bathbot_bringup.sim.scenario import Scenario
from bathbot_bringup.sim.scene import BathroomScene

BRIGHTNESS = 0.26  # mean linear light of a picture that an automatic exposure aims at


class Frame(NamedTuple):
    """One moment, perfect.

    Attributes:
        colour: sRGB, shape (H, W, 3) uint8.
        depth: True distance along the depth camera's axis [m], NaN where none, shape (H, W) float32.
        pose: Number of the still scene, for noise that stays as long as the scene does.
    """

    colour: NDArray[np.uint8]
    depth: NDArray[np.float32]
    pose: int


class SceneView(Protocol):
    """Anything a simulated camera can look at."""

    def frame(self, t: float, joints: NDArray[np.float64] | None) -> Frame:
        """The view at time t [s] with the arm at joint angles [rad], shape (6,); None: no arm."""
        ...


class BathroomView:
    """The bathroom of one seed as one unit sees it."""

    def __init__(self, scene: BathroomScene, scenario: Scenario, unit: D455Unit) -> None:
        """Draw what never moves.

        Args:
            scene: Who sits where.
            scenario: How they move, and the air.
            unit: The camera.
        """
        self._unit, self._scenario, self._seed = unit, scenario, scene.seed
        self.surface = scene.surface(scenario)
        self.T_base_depth = scene.T_base_camera
        self.T_base_colour = self.T_base_depth @ np.linalg.inv(unit.T_colour_depth)
        count = len(scene.dressed.vertices), len(scene.dressed.faces)
        stage = scene.stage()
        self._person, still = stage.split(*count)
        self._arm = ArmMesh()
        self._arm_stage = stage.holding(self._arm.mesh)
        self._still = draw(
            still, unit.colour, self.T_base_colour, picture_of_room(stage, unit.colour, self.T_base_colour)
        )
        room_depth = depth_of_room(stage.room, unit.depth, self.T_base_depth)
        self._still_depth = self._depth(still.mesh.vertices, still.mesh.faces, room_depth)
        self._expose()

    def frame(self, t: float, joints: ArrayLike | None = None) -> Frame:
        """The view at time t [s] with the arm at joint angles [rad], shape (6,); None: no arm."""
        vertices = self.surface.vertices(t)
        picture = draw(self._person.moved(vertices), self._unit.colour, self.T_base_colour, self._still)
        depth = self._depth(vertices, self._person.mesh.faces, self._still_depth)
        if joints is not None:
            arm = self._arm.vertices(joints)
            picture = draw(self._arm_stage.moved(arm), self._unit.colour, self.T_base_colour, picture)
            depth = self._depth(arm, self._arm.mesh.faces, depth)
        return Frame(self._through_air(picture), np.where(np.isfinite(depth), depth, np.nan), 0)

    def _depth(self, vertices: NDArray, faces: NDArray, behind: NDArray) -> NDArray[np.float32]:
        return rasterise(project_vertices(vertices, self._unit.depth, self.T_base_depth), faces, behind).depth

    def _expose(self) -> None:
        """Choose the exposure once, as an automatic exposure that is then locked."""
        first = draw(self._person, self._unit.colour, self.T_base_colour, self._still)
        gain = BRIGHTNESS / max(float(np.minimum(first.radiance, 1.0).mean()), 1e-3)
        lighting = self._person.lighting.scaled(gain)
        self._person = replace(self._person, lighting=lighting)
        self._arm_stage = replace(self._arm_stage, lighting=lighting)
        radiance = self._still.radiance * np.float32(gain)
        self._still = self._still._replace(radiance=radiance, colour=developed(radiance))

    def _through_air(self, picture: Rendering) -> NDArray[np.uint8]:
        """Steam and drops, which stay where they are, then the lens."""
        scenario = self._scenario
        if scenario.steam == 0.0 and scenario.drops == 0:
            return cv2.GaussianBlur(picture.colour, (0, 0), 0.5)
        light = picture.radiance
        if scenario.steam > 0.0:
            light = steamed(light, picture.depth, scenario.steam, np.random.default_rng([self._seed, 21]))
        light = dropped(light, scenario.drops, np.random.default_rng([self._seed, 22]))
        return developed(cv2.GaussianBlur(light, (0, 0), 0.5))
