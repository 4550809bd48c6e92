"""Trials of the sweeps, a few of each row, that found the body met too hard once."""

import pytest
from bathbot_bringup.evaluation.safety.sweep.sweep_list import choose_cases

TRIALS = (
    ("pushes", "rest-face-30", 0),  # 23 N before the guard knew that the give runs out
    ("pushes", "scrub-hand-20", 0),  # 18 N
    ("pushes", "rest-trunk-40", 0),  # 17 N
    ("leans", "blind-face-120-there", 0),  # 293 N
    ("leans", "seen-trunk-120-there", 0),  # 87 N
    ("paths", "hand-40", 1),  # 43 N
    ("paths", "trunk-on-face-40", 1),  # 24 N
)


@pytest.mark.parametrize(("sweep", "name", "seed"), TRIALS)
def test_a_body_is_never_met_harder_than_its_region_bears(sweep, name, seed):
    (case,) = choose_cases(sweep, [name])
    outcome = case.run(seed)
    assert outcome.peak_n <= outcome.bound_n, outcome
