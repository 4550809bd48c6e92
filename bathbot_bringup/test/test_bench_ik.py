"""Our inverse kinematics beside two libraries."""

import sys

import numpy as np
import pytest
from bathbot_bringup.bench.ik import bench_ik
from bathbot_bringup.errors import InputError


def test_all_three_solve_the_same_path_and_ours_is_the_fastest():
    times = bench_ik(poses=200, rounds=3)
    assert np.isfinite(times).all()
    assert times.ik_vs_eaik == pytest.approx(times.eaik_us_per_pose / times.ik_us_per_pose)
    assert times.ik_vs_pin > 1.0  # some thirty in truth, so no stall of the machine turns it round


def test_without_eaik_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "eaik.IK_HP", None)
    with pytest.raises(InputError, match="pip install eaik"):
        bench_ik(poses=100, rounds=1)


@pytest.mark.parametrize(("poses", "rounds"), [(10, 3), (200, 0)])
def test_too_few_poses_are_refused(poses, rounds):
    with pytest.raises(InputError, match=f"got {poses} and {rounds}"):
        bench_ik(poses, rounds)
