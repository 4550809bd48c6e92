"""The scrub head is written once: changed there, everything that knows it follows."""

import json
import subprocess
import sys

import pytest

pytestmark = pytest.mark.graph  # a process of its own, in which the head is another
ANSWERS = """
import inspect, json, sys
from dataclasses import replace
from bathbot_localize.arm import scrub_head
scrub_head.SCRUB_HEAD = replace(scrub_head.SCRUB_HEAD, **json.loads(sys.argv[1]))

import numpy as np
from bathbot_bringup.report.coverage import coverage
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_bringup.sim.brush import Brush
from bathbot_bringup.sim.camera.arm_mesh import ArmMesh
from bathbot_localize.arm.arm_shape import installed_shape
from bathbot_scrub.installed_arm import installed_arm
from bathbot_scrub.path.tool_pose import flange_poses
from bathbot_scrub.rm65.arm.urdf import urdf
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.rm65.force.wrench_filter import at_tip
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

arm, home = installed_arm(), installed_arm().home
lift = np.linalg.inv(arm.flange(home)) @ arm.head(home)
mesh = ArmMesh()
upright = np.zeros(6)
with Emulator(EmulatorSettings(port=0)) as emulator:
    tip = emulator.truth().T_base_head
print(json.dumps({
    "mask": -installed_shape().capsules[-2].start[2],
    "mask's brush": installed_shape().capsules[-1].radius,
    "workspace": installed_shape().workspace.behind - arm.flange_offset,
    "forward kinematics": lift[2, 3],
    "planner's flange": -flange_poses(np.eye(4))[2, 3],
    "planner's brush": ScrubPlannerSettings().brush_diameter / 2.0,
    "driver's wrench": at_tip([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])[3],
    "limits' most give": shipped_force_limits().comfortable("Trunk_skin", 1.0),
    "URDF": float(urdf().split('xyz="0.0 0.0 ')[-1].split('"')[0]),
    "simulated tip": float((np.linalg.inv(arm.flange(home)) @ tip)[2, 3]),
    "report": inspect.signature(coverage).parameters["radius"].default,
    "simulated brush": Brush().radius,
    "simulated give": Brush().give,
    "picture": float(mesh.vertices(upright)[:, 2].max() - arm.flange(upright)[2, 3]),
}))
"""


def answers(**changed):
    """What each of them says of a head of which something is changed."""
    done = subprocess.run(
        [sys.executable, "-c", ANSWERS, json.dumps(changed)],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    return json.loads(done.stdout)


LENGTHS = ("mask", "workspace", "forward kinematics", "planner's flange", "driver's wrench", "URDF",
           "simulated tip", "picture")  # fmt: skip


@pytest.mark.parametrize("length", [0.10, 0.16])
def test_all_follow_its_length(length):
    said = answers(length=length)
    assert {name: said[name] for name in LENGTHS} == pytest.approx(dict.fromkeys(LENGTHS, length))


def test_all_follow_its_brush():
    said = answers(brush_radius=0.031, give=0.008)
    for name in ("mask's brush", "planner's brush", "report", "simulated brush"):
        assert said[name] == pytest.approx(0.031), name
    assert said["simulated give"] == pytest.approx(0.008)
    assert said["limits' most give"] <= 0.008
