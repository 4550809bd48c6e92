"""Scenarios: files, limits and the size of the motion."""

import numpy as np
import pytest
from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.scenario import BodyMotion, Scenario, Shift, load_scenario, scenario_names
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_loads_and_moves_smoothly(name):
    motion = BodyMotion(load_scenario(name), 0)
    places = np.array([motion.at(t).T_rest_moved[:3, 3] for t in np.arange(0.0, 70.0, 0.05)])
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.01  # [m] per 50 ms


def test_the_named_scenarios_are_there():
    assert {"calm", "still", "breathing", "restless", "lean"} <= set(scenario_names())


@given(t=st.floats(0.0, 1000.0))
def test_nobody_moves_in_still(t):
    state = BodyMotion(load_scenario("still"), 3).at(t)
    assert_allclose(state.T_rest_moved, np.eye(4), atol=1e-15)
    assert state.breath == 0.0


@given(t=st.floats(0.0, 1000.0), seed=st.integers(0, 100))
def test_calm_stays_within_its_amplitudes(t, seed):
    state = BodyMotion(load_scenario("calm"), seed).at(t)
    assert abs(state.breath) <= 0.002
    assert np.abs(state.T_rest_moved[:3, 3]).max() <= 0.001


def test_restless_shifts_fifteen_millimetres_at_half_a_minute():
    motion = BodyMotion(load_scenario("restless"), 0)
    quiet = BodyMotion(Scenario(sway_amplitude=0.002), 0)
    moved = motion.at(31.0).T_rest_moved[:3, 3] - quiet.at(31.0).T_rest_moved[:3, 3]
    assert_allclose(np.linalg.norm(moved), 0.015, atol=5e-4)
    assert_allclose(motion.at(29.9).T_rest_moved[:3, 3], quiet.at(29.9).T_rest_moved[:3, 3], atol=1e-12)


@given(t=st.floats(-10.0, 10.0))
def test_a_shift_goes_from_nothing_to_all_of_it(t):
    shift = Shift(time=1.0, duration=2.0)
    assert 0.0 <= shift.progress(t) <= 1.0
    assert shift.progress(1.0) == 0.0
    assert shift.progress(2.0) == 0.5
    assert shift.progress(3.0) == 1.0


def test_lean_turns_forward_about_the_seat():
    forward = BodyMotion(load_scenario("lean"), 0).at(40.0).T_rest_moved[:3, :3] @ [0.0, 0.0, 1.0]
    assert_allclose(np.rad2deg(np.arctan2(forward[0], forward[2])), 4.0, atol=1e-9)


def test_an_unknown_scenario_is_refused_with_the_names():
    with pytest.raises(SettingsError, match="calm"):
        load_scenario("dancing")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        pytest.param("breathing: 3", "unknown key breathing", id="key"),
        pytest.param("breath_amplitude: 0.5", "between 0 and", id="amplitude"),
        pytest.param("shifts: [{time: 1.0, duration: 0.0}]", "longer than 0 s", id="duration"),
        pytest.param("shifts: [{when: 1.0}]", "cannot be read", id="shift key"),
        pytest.param("[1, 2", "cannot be read", id="yaml"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(SettingsError, match=message) as caught:
        load_scenario(str(path))
    assert "\n" not in str(caught.value)
