"""The way home that the arm came on: when it is not taken, and why."""

import numpy as np
import pytest
from arm_poses import ARM, HOME, PLANNER, TARGET, TOUCH, facing, joints_at
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.tool_path import retreated
from bathbot_scrub.rm65.paths.free_space import FreeSpace
from numpy.testing import assert_allclose

SPACE = FreeSpace(ARM, HOME, ARM.limits)
STANDOFF = retreated(TARGET, 0.06)
HIGH = facing((0.45, 0.0, 0.5))  # where the arm can stand in two postures


def came(*through):
    """From home to the stand-off, in straight lines through joints."""
    return PLANNER.joint_path(HOME, *through, joints_at(STANDOFF))


def over_the_skin(start, way):
    return next(SPACE.over_the_skin(start, way))


def postures(T):
    """Two that hold the head there, elbow up and down."""
    found = ARM.solve_head(T, ARM.limits)
    one, other = found[np.isfinite(found).all(-1)]
    return one, other


def test_it_ends_at_home_and_passes_the_stand_off():
    way = np.array(over_the_skin(TOUCH, came()))
    assert_allclose(way[-1], HOME)
    assert np.abs(way - joints_at(STANDOFF)).max(-1).min() < 1e-6


def test_not_where_the_arm_did_not_come_from_home():
    with pytest.raises(UnreachableError, match="did not come from home"):
        over_the_skin(TOUCH, PLANNER.joint_path(HOME + 0.1, joints_at(STANDOFF)))
    with pytest.raises(UnreachableError, match="did not come from home"):
        next(SPACE.straight_back(TOUCH, PLANNER.joint_path(HOME + 0.1, joints_at(STANDOFF)), TARGET))


def test_not_over_skin_that_nobody_has_looked_at():
    aside = TARGET.copy()
    aside[:3, 3] += 0.31 * np.array([0.0, 1.0, 0.0])
    far = PLANNER.joint_path(HOME, joints_at(aside))
    with pytest.raises(UnreachableError, match=r"the stand-off is 0\.3\d m away, more than 0\.3 m"):
        over_the_skin(TOUCH, far)


def test_not_in_another_posture_than_it_came_in():
    (one, other), standoff = postures(HIGH), postures(retreated(HIGH, 0.06))[0]
    way = PLANNER.joint_path(HOME, standoff)
    over_the_skin(one, way)
    with pytest.raises(UnreachableError, match="another branch"):
        over_the_skin(other, way)


def test_not_where_a_wound_up_wrist_would_pass_its_stop():
    turn = 2.0 * np.pi * np.eye(6)[5]
    wound, aside = TOUCH - turn, joints_at(STANDOFF) - 1.22 * turn
    assert ARM.limits.contain([wound, aside]).all()
    over_the_skin(wound, came())
    with pytest.raises(UnreachableError, match="a joint would pass its limit"):
        over_the_skin(wound, came(aside))


def test_straight_to_the_stand_off_only_on_the_arms_side_of_the_person():
    """From elbow down to elbow up the joints' straight line pushes the arm at them."""
    (one, other), standoff = postures(HIGH), postures(retreated(HIGH, 0.06))[0]
    way, side = PLANNER.joint_path(HOME, standoff), retreated(HIGH, -0.03)
    back = next(SPACE.straight_back(one, way, side))
    assert_allclose(back[0], standoff)
    assert_allclose(back[-1], HOME)
    with pytest.raises(UnreachableError, match="towards the person"):
        next(SPACE.straight_back(other, way, side))
