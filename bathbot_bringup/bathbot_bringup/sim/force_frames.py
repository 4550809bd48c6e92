"""The external force in other frames than the sensor's. Turned only: torques stay about the sensor."""

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.controller import Controller

Array = NDArray[np.float64]


def in_work_frame(controller: Controller, wrench: Array) -> Array:
    """A wrench of the sensor frame, shape (6,), in axes of the work frame."""
    return _turned(controller.setup.works.T[:3, :3].T @ controller.T_base_flange[:3, :3], wrench)


def in_tool_frame(controller: Controller, wrench: Array) -> Array:
    """A wrench of the sensor frame, shape (6,), in axes of the tool frame."""
    return _turned(controller.setup.tools.T[:3, :3].T, wrench)


def _turned(rotation: Array, wrench: Array) -> Array:
    return np.concatenate([rotation @ wrench[:3], rotation @ wrench[3:]])
