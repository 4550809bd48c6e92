"""The arm as Pinocchio sees it, from our URDF: Jacobian, manipulability, distance to itself and to walls.

The driver asks it once per sample of a planned path, never in the control loop. Importing this module loads
Pinocchio (about 0.3 s), so only who plans motions imports it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.arm import DrivenArm
from bathbot_scrub.rm65.arm.walls import Wall

Array = NDArray[np.float64]
_NEIGHBOURS = 2  # links this near in the chain are kept apart by the limits of the joints between them


class Near(NamedTuple):
    """The two things that are nearest to each other, and their distance [m], negative where they overlap."""

    first: str
    second: str
    distance: float


class ArmModel:
    """An arm between walls. Not thread-safe: it keeps the result of its last call."""

    def __init__(self, arm: DrivenArm, walls: Sequence[Wall] = ()) -> None:
        """Build the model from the arm's URDF."""
        self._arm, description = arm, arm.description()
        self.model = pin.buildModelFromXML(description)
        self._data = self.model.createData()
        self._head = self.model.getFrameId(arm.tool.frame)
        self._shapes, self._names = self._geometry(description, walls)
        self._shape_data = pin.GeometryData(self._shapes)

    def head(self, joints: ArrayLike) -> Array:
        """T_base_head, shape (4, 4), for joints [rad], shape (J,)."""
        pin.framesForwardKinematics(self.model, self._data, np.asarray(joints, dtype=float))
        return self._data.oMf[self._head].homogeneous

    def jacobian(self, joints: ArrayLike) -> Array:
        """Jacobian of the scrub head in the base frame, shape (6, J): rows velocity, then rotation."""
        return pin.computeFrameJacobian(
            self.model,
            self._data,
            np.asarray(joints, dtype=float),
            self._head,
            pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
        )

    def manipulability(self, joints: ArrayLike) -> float:
        """Yoshikawa's measure sqrt(det(J J^T)) of the head, [m^3]; 0 in a singular posture."""
        return float(abs(np.linalg.det(self.jacobian(joints))))

    def nearest(self, joints: ArrayLike) -> Near:
        """What of the arm is nearest to another part of it or to a wall, at joints [rad], shape (J,)."""
        q = np.asarray(joints, dtype=float)
        pin.computeDistances(self.model, self._data, self._shapes, self._shape_data, q)
        distances = [result.min_distance for result in self._shape_data.distanceResults]
        least = int(np.argmin(distances))
        pair = self._shapes.collisionPairs[least]
        return Near(self._names[pair.first], self._names[pair.second], distances[least])

    def _geometry(self, description: str, walls: Sequence[Wall]) -> tuple[pin.GeometryModel, list[str]]:
        """Capsules of the links and half spaces of the walls, with the pairs that may meet; their names."""
        drawn = pin.buildGeomFromUrdfString(self.model, description, pin.GeometryType.COLLISION)
        shapes, names = pin.GeometryModel(), []
        for shape in drawn.geometryObjects:
            if isinstance(shape.geometry, coal.Capsule):  # the spheres at its ends are part of it
                shapes.addGeometryObject(shape)
                names.append(self.model.frames[shape.parentFrame].name)
        links = len(names)
        for number, wall in enumerate(walls):
            solid = coal.Halfspace(np.array(wall.normal), wall.offset)
            shapes.addGeometryObject(pin.GeometryObject(f"wall{number}", 0, pin.SE3.Identity(), solid))
            names.append(wall.name)
        chain = (*self._arm.link_names, self._arm.tool.frame)
        places = [chain.index(name) for name in names[:links]]
        for first in range(links):
            for second in range(first + 1, links):
                if places[second] - places[first] > _NEIGHBOURS:
                    shapes.addCollisionPair(pin.CollisionPair(first, second))
            if names[first] not in self._arm.shape.standing:
                for wall in range(links, len(names)):
                    shapes.addCollisionPair(pin.CollisionPair(first, wall))
        return shapes, names
