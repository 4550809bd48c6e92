"""Reach of the arm along a path."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_scrub.path.reach import Reach
from bathbot_scrub.rm65.arm.rm65 import RM65
from scipy.spatial.transform import Rotation

ARM = RM65("6F")
STANDING = np.radians([20.0, -45.0, -60.0, 15.0, -70.0, 10.0])


def line(direction, length, start=STANDING, count=100):
    poses = np.tile(ARM.head(start), (count, 1, 1))
    poses[:, :3, 3] += np.outer(np.linspace(0.0, length, count), direction)
    return poses


def test_head_is_held_where_the_arm_stands():
    assert Reach(ARM, STANDING).holds(ARM.head(STANDING)[None]).all()


def test_near_poses_are_followed_to_the_end():
    followed, why = Reach(ARM, STANDING).follow(line((0, 0, 1.0), 0.05))
    assert (followed, why) == (100, "")


def test_path_out_of_reach_ends_at_the_sphere_of_the_arm():
    """The wrist centre cannot leave the sphere of 0.466 m about the shoulder."""
    poses = line((1.0, 0, 0), 0.6)
    followed, why = Reach(ARM, STANDING).follow(poses)
    wrist = poses[:, :3, 3] - (0.10 + 0.1725) * poses[:, :3, 2]
    inside = np.linalg.norm(wrist - [0, 0, 0.2405], axis=1) < 0.466
    assert 0 < followed <= int(np.argmin(inside)) + 1
    assert why
    held = Reach(ARM, STANDING).holds(poses)
    assert not held[~inside].any()


def test_a_full_turn_of_the_head_is_limited_by_joint_6():
    reach = Reach(ARM, STANDING)
    poses = np.tile(ARM.head(STANDING), (400, 1, 1))
    for sign, limit in ((1.0, 350.0), (-1.0, 370.0)):
        angles = sign * np.linspace(0.0, 400.0, 400)[:, None]
        turns = Rotation.from_euler("z", angles, degrees=True).as_matrix()
        spun = poses @ np.array([transform_from(turn) for turn in turns])
        spun[:, 0, 3] += np.linspace(0.0, 0.02, 400)
        followed, why = reach.follow(spun)
        assert abs(followed - limit) < 12
        assert "limits" in why


def test_easy_reach_leaves_out_the_straight_wrist():
    straight = STANDING.copy()
    straight[4] = np.radians(2.0)
    reach = Reach(ARM, straight)
    pose = ARM.head(straight)[None]
    assert reach.holds(pose).all()
    assert not reach.holds(pose, easily=True).any()


def test_advancing_piece_by_piece_goes_as_far_as_following_all_at_once():
    kinematics = RM65("6F")
    start = np.radians([10.0, -60.0, -60.0, -20.0, 50.0, 20.0])
    poses = np.tile(kinematics.head(start), (120, 1, 1))
    poses[:, :3, 3] += 0.002 * np.arange(120)[:, None] * poses[0, :3, 1]
    count, why = Reach(kinematics, start).follow(poses)
    assert 10 < count < 120
    assert why
    walker, done = Reach(kinematics, start), 0
    for piece in np.split(poses, 6):
        taken, ended = walker.advance(piece)
        done += taken
        assert bool(ended) == (taken < len(piece))
        if ended:
            break
    assert ended
    assert abs(done - count) <= 1


def test_a_joint_that_meets_its_limit_before_the_end_of_reach_ends_the_path_there():
    """The head turns a full turn, then the path leaves the reach: what comes first counts."""
    poses = np.tile(ARM.head(STANDING), (800, 1, 1))
    turns = Rotation.from_euler("z", np.linspace(0.0, 400.0, 400)[:, None], degrees=True).as_matrix()
    poses[:400, :3, :3] = poses[:400, :3, :3] @ turns
    poses[400:, :3, :3] = poses[399, :3, :3]
    poses[400:, 0, 3] += np.linspace(0.0, 0.6, 400)
    assert Reach(ARM, STANDING).follow(poses)[0] == Reach(ARM, STANDING).follow(poses[:400])[0] < 400


def test_poses_at_which_a_link_would_come_near_the_body_are_not_held():
    """A point beside the wrist of one pose: that and its neighbours go, the far ones stay."""
    poses = line((0.0, 1.0, 0.0), 0.16)
    held = Reach(ARM, STANDING).holds(poses)
    wrists = poses[:, :3, 3] - (0.10 + 0.1725) * poses[:, :3, 2]
    at = int(np.flatnonzero(held)[-1])
    beside = wrists[at] + (0.04 + 0.005) * np.array([0.0, 1.0, 0.0])
    free = Reach(ARM, STANDING, beside[None]).holds(poses)
    assert held[0]
    assert free[0]
    assert not free[at]
    assert (free <= held).all()


def test_skin_under_the_brush_is_no_obstacle():
    tip = ARM.head(STANDING)
    across = 0.04 * np.indices((7, 7)).reshape(2, -1).T - 0.12
    skin = tip[:3, 3] + across @ tip[:3, :2].T
    assert Reach(ARM, STANDING, skin).holds(tip[None]).all()
