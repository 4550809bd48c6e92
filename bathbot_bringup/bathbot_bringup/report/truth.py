"""The simulated truth a run is judged by: the same pure functions the simulator itself used."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse, rotate
from bathbot_perception.classes import SKIN_CLASSES
from numpy.typing import NDArray

from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.bathing.steps import Sighting
from bathbot_bringup.report.run_data import TargetSeen
from bathbot_bringup.sim.body_surface import BodySurface
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings
from bathbot_bringup.sim.scenario import load_scenario
from bathbot_bringup.sim.scene import BathroomScene

Array = NDArray[np.float64]


def seen_target(sighting: Sighting) -> TargetSeen:
    """A contact target as the client saw it."""
    target = sighting.target
    position = np.asarray(target.T_base_target)[:3, 3]
    return TargetSeen(sighting.time, target.region, np.asarray(target.pixel, dtype=float), position)


class Truth:
    """Body and camera of one run."""

    def __init__(self, settings: DemoSettings, epoch: float) -> None:
        """Rebuild the scene.

        Args:
            settings: Of the run.
            epoch: ROS time at which the body's motion began [s].
        """
        scene = BathroomScene(settings.seed)
        unit = SimCameraSettings(preset=settings.preset).unit()
        self._epoch = epoch
        self.colour = unit.colour
        self.T_base_colour: Array = scene.T_base_camera @ inverse(unit.T_colour_depth)
        self.surface: BodySurface = scene.surface(load_scenario(settings.scenario))
        self.labels: NDArray[np.uint8] = scene.dressed.labels

    def target_error(self, target: TargetSeen) -> Array:
        """Found minus true position of a contact target [m] in the base frame, shape (3,).

        The true position is where the ray through the target's pixel, of the camera as it really is,
        met the body at the time of the picture; NaN where it met nothing.
        """
        ray = rotate(self.T_base_colour, self.colour.directions(target.pixel))
        origin = self.T_base_colour[:3, 3]
        return target.position - self.surface.true_point(origin, ray, target.time - self._epoch)

    def vertices(self, time: float) -> Array:
        """Points of the body in the base frame [m], shape (V, 3), at a ROS time [s]."""
        return self.surface.vertices(time - self._epoch)

    def skin_faces(self, region: str) -> NDArray[np.bool_]:
        """Which triangles of the body are skin of a region, shape (F,)."""
        return self.labels == SKIN_CLASSES.index(region)
