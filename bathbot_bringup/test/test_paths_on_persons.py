"""Paths that the planner lays on simulated persons are never too deep for the driver, with room to spare."""

from dataclasses import replace

import numpy as np
import pytest
from bathbot_bringup.sim.camera.d455_camera import D455Camera
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings
from bathbot_bringup.sim.render.boxes import skin_boxes
from bathbot_bringup.sim.render.render import render
from bathbot_bringup.sim.scene import BathroomScene
from bathbot_localize.arm.arm_shape import installed_shape
from bathbot_localize.regions import SkinRegion
from bathbot_localize.target.body_cloud import BodyCloud
from bathbot_localize.target.localizer import locate_all, make_frame, surface_of
from bathbot_localize.target_localizer_settings import TargetLocalizerSettings
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_scrub.arm.force_limits import load_force_limits
from bathbot_scrub.errors import ScrubError
from bathbot_scrub.path.planner import PathPlanner, Task
from bathbot_scrub.rm65.motion.path_depth import MOST_TILT, Bristles, Felt, Skin, check_depth, depths
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

LIMITS, LOOK, PLAN = load_force_limits(), TargetLocalizerSettings(), ScrubPlannerSettings()
BRISTLES = Bristles(LIMITS.contact, LIMITS.give / 0.010)


def seen(seed):
    """A person as the camera sees them: the last frame, the cloud after 2 s, the boxes of skin."""
    camera, scene = D455Camera(SimCameraSettings(seed=seed, scenario="breathing")), BathroomScene(seed)
    unit = camera.unit
    T_base_colour = scene.T_base_camera @ np.linalg.inv(unit.T_colour_depth)
    picture = render(scene.stage(), unit.colour, T_base_colour)
    boxes = [
        SkinRegion(SKIN_CLASSES[box.part], 0.9, (box.left, box.top, box.right + 1, box.bottom + 1))
        for box in skin_boxes(picture.parts, picture.sides)
    ]
    cloud = BodyCloud(LOOK.cloud_voxel, LOOK.cloud_memory, LOOK.arm_margin)
    for stamp in (0.0, 1.0, 2.0):
        frame = make_frame(
            camera.shoot(stamp).depth, unit.depth, unit.colour, unit.T_colour_depth, T_base_colour,
            installed_shape(), {},
        )  # fmt: skip
        points = cloud.update(frame, stamp).points
    return frame, points, boxes


@pytest.mark.parametrize("seed", [2, 107])
def test_no_path_on_a_person_is_refused_for_its_depth(seed):
    frame, cloud, boxes = seen(seed)
    rng, planned = np.random.default_rng(seed), 0
    for target in locate_all(frame, boxes, LOOK).targets:
        box = next(
            one.box
            for one in boxes
            if one.name == target.region and one.box[0] <= target.pixel[0] + 0.5 <= one.box[2]
        )
        force, wrong = float(rng.uniform(1.0, 2.5)), float(rng.normal(0.0, 0.002))
        head = target.T_base_target.copy()  # where it stands when it has felt the skin
        head[:3, 3] += (force / BRISTLES.stiffness + wrong) * head[:3, 2]
        settings = replace(PLAN, compression=LIMITS.comfortable(target.region, PLAN.compression))
        try:
            task = Task(surface_of(frame, box, LOOK), 2.0, target.T_base_target, head)
            poses = PathPlanner(task, settings).poses
        except ScrubError:  # nothing to wash there
            continue
        felt = Felt(head, force)
        for known in (Skin(felt, felt, cloud), Skin(felt, felt, np.empty((0, 3)))):
            check_depth(poses, known, BRISTLES)
        found = depths(poses, Skin(felt, felt, cloud), BRISTLES)
        assert (found.most - found.depth).min() > 0.004, target.region
        assert found.tilt.max() < MOST_TILT
        planned += 1
        deeper = poses.copy()
        deeper[:, :3, 3] += 0.02 * poses[:, :3, 2]
        assert (depths(deeper, Skin(felt, felt, cloud), BRISTLES).depth > BRISTLES.give).mean() > 0.9
    assert planned >= 4
