"""The simulated brush: bristles, skin, friction and torque."""

import numpy as np
import pytest
from bathbot_bringup.sim.arm.controller.controller_force import ForceSensor
from bathbot_bringup.sim.arm.emulator.surface import NoSurface, PlaneSurface, SphereSurface
from bathbot_bringup.sim.brush import SKIN_STIFFNESS, Brush
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_scrub.rm65.force.wrench_filter import at_tip
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

BRUSH = Brush()
STILL = np.zeros(3)
WALL = PlaneSurface((-1.0, 0.0, 0.0), -0.5)  # x = 0.5, seen from smaller x


def head(depth, tilt_deg=0.0, position=(0.5, 0.0, 0.3)):
    """Head pressed into the wall by `depth` [m]."""
    turn = Rotation.from_euler("y", 90.0 + tilt_deg, degrees=True).as_matrix()
    return transform_from(turn, np.array(position) + depth * turn[:, 2])


@given(bends=st.lists(st.floats(-0.02, 0.03), min_size=2, max_size=10), stiffness=st.floats(1e4, 1e5))
def test_force_never_falls_with_bend(bends, stiffness):
    forces = BRUSH.normal_force(np.sort(bends), stiffness)
    assert (np.diff(forces) >= 0.0).all()
    assert (forces[np.sort(bends) <= 0.0] == 0.0).all()


def test_bristles_then_skin_by_hand():
    assert BRUSH.normal_force(np.array(0.005), 25e3) == pytest.approx(2.0)
    assert BRUSH.normal_force(np.array(0.012), 25e3) == pytest.approx(4.0 + 50.0)


@given(depth=st.floats(-0.05, 0.02))
def test_on_a_plane_the_force_is_that_of_the_depth(depth):
    contact = BRUSH.touch(head(depth), STILL, WALL, 0.0)
    expected = BRUSH.normal_force(np.array(depth), SKIN_STIFFNESS["Trunk_skin"])
    assert_allclose(contact.force, [-expected, 0.0, 0.0], atol=1e-6)
    assert contact.compression + contact.indentation == pytest.approx(depth, abs=1e-9)
    assert contact.compression <= BRUSH.give
    assert (contact.part == "Trunk_skin") == (depth > 0.0) or abs(depth) < 1e-9


@given(angle=st.floats(0.0, 6.28), speed=st.floats(0.03, 0.2))
def test_friction_opposes_the_motion_and_has_its_share(angle, speed):
    along = np.array([0.0, np.cos(angle), np.sin(angle)])
    contact = BRUSH.touch(head(0.005), speed * along, WALL, 0.0)
    assert_allclose(contact.force, [-2.0, *(-0.3 * 2.0 * along[1:])], atol=1e-3)


@given(turn=st.floats(0.0, 360.0), depth=st.floats(0.001, 0.009))
def test_turning_about_its_axis_changes_nothing_on_a_ball(turn, depth):
    ball = SphereSurface((0.6, 0.0, 0.3), 0.1)
    pose = head(depth)
    turned = pose @ transform_from(
        Rotation.from_euler("z", 60.0 * round(turn / 60.0), degrees=True).as_matrix()
    )
    one, other = (BRUSH.touch(T, STILL, ball, 0.0) for T in (pose, turned))
    assert_allclose(one.force, other.force, atol=1e-9)
    assert one.compression == pytest.approx(depth)


def test_a_tilted_brush_is_turned_back():
    contact = BRUSH.touch(head(0.004, tilt_deg=8.0), STILL, WALL, 0.0)
    lever = contact.torque @ np.cross(head(0.0, 8.0)[:3, 2], head(0.0)[:3, 2])
    assert lever > 0.0


def test_nothing_is_met_in_empty_space():
    contact = BRUSH.touch(head(0.0), STILL, NoSurface(), 0.0)
    assert_allclose(contact.force, 0.0)
    assert contact.part == ""
    assert -1.0 < contact.compression < 0.0
    assert np.isfinite(contact.compression)


def test_sensor_is_zeroed_to_the_contact_force_alone():
    sensor = ForceSensor(np.random.default_rng(0))
    pose = transform_from(Rotation.from_euler("y", 70.0, degrees=True).as_matrix(), (0.3, 0.0, 0.3))
    push = np.array([0.5, -0.2, 3.0])
    for _ in range(40):
        sensor.measure(pose, STILL, STILL)
    assert np.linalg.norm(sensor.reading.zero[:3]) > 0.2
    assert np.linalg.norm(sensor.reading.raw[:3]) > 3.0
    sensor.clear()
    readings = np.array([sensor.measure(pose, pose[:3, :3] @ push, STILL).zero for _ in range(200)])
    assert_allclose(readings.mean(0)[:3], push, atol=0.05)
    assert_allclose(at_tip(readings.mean(0))[3:], 0.0, atol=0.005)
    assert readings[:, :3].std(0).mean() == pytest.approx(0.05, rel=0.2)
