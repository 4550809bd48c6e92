"""Segments: evenly spaced, smoothly joined, on the newest surface."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import rotation_angle
from bathbot_scrub.path.height_field import HeightField
from bathbot_scrub.path.patch import PatchGrid
from bathbot_scrub.path.scan_lines import Ground, scan_paths
from bathbot_scrub.path.segments import SegmentShaper
from bathbot_scrub.path.tool_pose import head_rotations
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

SETTINGS = ScrubPlannerSettings()
GRID = PatchGrid(np.eye(4), 0.12, 0.12, 0.004)
X, Y = np.meshgrid(GRID.x, GRID.y)
RADIUS = 0.15
PATH = scan_paths(Ground(GRID, (np.abs(X) <= 0.06) & (np.abs(Y) <= 0.04)), [-0.035, 0.0, 0.035], 0.035)[0]


def limb(lift=0.0, tilt=0.0):
    height = np.sqrt(RADIUS**2 - Y**2) - RADIUS + lift + tilt * X
    return HeightField(GRID, height, np.ones(X.shape, dtype=bool))


def all_segments(fields, count=30, tip=None, rotation=None):
    """Poses of each segment; segment i is laid on the field `fields(i)`."""
    shaper = SegmentShaper(PATH, SETTINGS)
    joint, ends, pieces = shaper.start(fields(0), tip, rotation), False, []
    while not ends:
        poses, joint, ends = shaper.lay(joint, fields(len(pieces)), count)
        pieces.append(poses)
    return pieces


STILL = limb()
WHOLE = np.concatenate(all_segments(lambda _: STILL))


def depth_below(poses, lift=0.0):
    """How far tips are below the limb's skin along its normal [m]."""
    return RADIUS - np.hypot(poses[:, 1, 3], poses[:, 2, 3] + RADIUS - lift)


def test_segments_have_the_wanted_length_and_the_last_takes_the_rest():
    pieces = all_segments(lambda _: STILL)
    assert {len(piece) for piece in pieces[:-1]} == {30}
    assert 12 <= len(pieces[-1]) <= 42


@pytest.mark.parametrize("count", [10, 30, 77])
def test_segments_together_are_the_whole_path(count):
    """Cut into pieces of any size, the path is the same to 30 um."""
    cut = np.concatenate(all_segments(lambda _: STILL, count))
    assert abs(len(cut) - len(WHOLE)) <= 1
    shared = min(len(cut), len(WHOLE))
    assert np.linalg.norm(cut[:shared, :3, 3] - WHOLE[:shared, :3, 3], axis=1).max() < 3e-5
    turned = rotation_angle(np.swapaxes(cut[:shared, :3, :3], 1, 2) @ WHOLE[:shared, :3, :3])
    assert np.degrees(turned).max() < 6.0


def test_spacing_is_even():
    spacing = np.linalg.norm(np.diff(WHOLE[:, :3, 3], axis=0), axis=1)
    assert spacing.max() <= SETTINGS.step + 1e-9
    assert spacing.min() > 0.998 * SETTINGS.step


def test_bristles_are_pressed_in_by_the_compression():
    assert_allclose(depth_below(WHOLE), SETTINGS.compression, atol=5e-5)


def test_poses_follow_equation_14():
    assert_allclose(np.linalg.det(WHOLE[:, :3, :3]), 1.0)
    normals = np.column_stack([0 * WHOLE[:, 0, 3], WHOLE[:, 1, 3], WHOLE[:, 2, 3] + RADIUS])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    wanted = head_rotations(normals[1:-1], WHOLE[2:, :3, 3] - WHOLE[:-2, :3, 3])
    lag = np.degrees(rotation_angle(np.swapaxes(wanted, 1, 2) @ WHOLE[1:-1, :3, :3]))
    assert lag.max() < 6.5
    assert np.all(np.sum(WHOLE[:, :3, 2] * normals, axis=1) < -0.99)


@settings(max_examples=15)
@given(lift=st.floats(-0.005, 0.005), tilt=st.floats(-0.05, 0.05), which=st.integers(1, 5))
def test_joints_stay_smooth_when_the_skin_has_moved(lift, tilt, which):
    """No jump in place, direction or orientation, whatever the next surface is like."""
    pieces = all_segments(lambda index: STILL if index < which else limb(lift, tilt))
    poses = np.concatenate(pieces)
    steps = np.diff(poses[:, :3, 3], axis=0)
    assert_allclose(np.linalg.norm(steps, axis=1), SETTINGS.step, rtol=3e-3)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    bends = np.degrees(np.arccos(np.clip(np.sum(steps[:-1] * steps[1:], axis=1), -1, 1)))
    assert bends.max() < 12.0
    turns = np.degrees(rotation_angle(np.swapaxes(poses[:-1, :3, :3], 1, 2) @ poses[1:, :3, :3]))
    assert turns.max() < 14.0


def test_after_a_shift_the_path_follows_the_new_skin():
    """3 mm along the normal before the third segment: reached within the blend, kept to the end."""
    pieces = all_segments(lambda index: limb(0.003 if index >= 2 else 0.0))
    blend = int(SETTINGS.blend / SETTINGS.step) + 2
    assert_allclose(depth_below(np.concatenate(pieces[:2])), SETTINGS.compression, atol=5e-5)
    moved = depth_below(np.concatenate(pieces[2:])[blend:], lift=0.003)
    assert_allclose(moved, SETTINGS.compression, atol=1e-4)


def test_path_starts_where_the_head_stands():
    tip = STILL.points_at(np.array([[0.0, 0.0]]))[0] + [0.002, -0.003, -0.002]
    stands = head_rotations([0, 0.1, 1], [1, 0.2, 0])
    poses = np.concatenate(all_segments(lambda _: STILL, tip=tip, rotation=stands))
    assert_allclose(poses[0, :3, 3], tip, atol=1e-9)
    turns = np.degrees(rotation_angle(np.swapaxes(poses[:-1, :3, :3], 1, 2) @ poses[1:, :3, :3]))
    assert turns[:20].max() < 3.5
    assert_allclose(depth_below(poses[20:]), SETTINGS.compression, atol=1e-4)


def test_head_that_faces_back_turns_round_gradually():
    back = head_rotations([0, 0, 1], [-1, 0, 0])
    poses = np.concatenate(all_segments(lambda _: STILL, rotation=back))
    turns = np.degrees(rotation_angle(np.swapaxes(poses[:-1, :3, :3], 1, 2) @ poses[1:, :3, :3]))
    assert turns.max() < 15.0


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize("off", [-2.0, 0.0, 2.0])
def test_half_a_turn_at_the_start_unwinds_the_wrist(order, off):
    """However the head stands at first, it never turns by more than a turn about itself."""
    path = scan_paths(Ground(GRID, (np.abs(X) <= 0.06) & (np.abs(Y) <= 0.04)), [-0.035, 0.0, 0.035], 0.035)[
        order
    ]
    shaper = SegmentShaper(path, SETTINGS)
    along = [np.cos(np.radians(off)), np.sin(np.radians(off)), 0.0]
    start = head_rotations([0.0, 0.0, 1.0], along)
    joint, ends, pieces = shaper.start(STILL, None, start), False, [start[None]]
    while not ends:
        poses, joint, ends = shaper.lay(joint, STILL, 30)
        pieces.append(poses[:, :3, :3])
    rotations = np.concatenate(pieces)
    steps = Rotation.from_matrix(np.swapaxes(rotations[:-1], 1, 2) @ rotations[1:]).as_rotvec()[:, 2]
    yaw = np.degrees(np.concatenate([[0.0], np.cumsum(steps)]))
    if order >= 2:  # half a turn at first, and the lines turn it back
        assert np.abs(yaw).max() < 215.0
    assert np.ptp(yaw) < 375.0


def test_a_hollow_is_pressed_less():
    """In a bowl the bristles beside the middle bend further: the head stays higher, but in touch."""
    bowl = HeightField(
        GRID, 0.06 - np.sqrt(0.06**2 - np.clip(Y, -0.05, 0.05) ** 2), np.ones(X.shape, dtype=bool)
    )
    shaper = SegmentShaper(PATH, SETTINGS)
    joint = shaper.start(bowl, None, None)
    poses, _, _ = shaper.lay(joint, bowl, 20)
    pressed = np.hypot(poses[:, 1, 3], 0.06 - poses[:, 2, 3]) - 0.06
    assert np.all((pressed[2:] > 0.0028) & (pressed[2:] < SETTINGS.compression))
