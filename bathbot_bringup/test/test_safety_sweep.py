"""The sweeps: which cases there are, what bounds them, and how they are told."""

import io

import pytest
from bathbot_bringup.command.arguments import name_list, refuse_with
from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.safety.sweep import sweep_run
from bathbot_bringup.evaluation.safety.sweep.pushes import Push
from bathbot_bringup.evaluation.safety.sweep.sweep_case import REGIONS, SLOW, Outcome
from bathbot_bringup.evaluation.safety.sweep.sweep_list import SWEEPS, choose_cases
from bathbot_bringup.evaluation.safety.sweep.sweep_run import SafetySweep, sweep_safety
from bathbot_bringup.evaluation.safety.sweep.sweep_table import markdown, out_of_bounds, summarise
from bathbot_scrub.arm.force_limits import shipped_force_limits
from rich.console import Console


@pytest.mark.parametrize("name", SWEEPS)
def test_every_case_has_a_name_of_its_own_and_every_region_is_swept(name):
    cases = choose_cases(name)
    assert len({case.name for case in cases}) == len(cases)
    assert {case.region for case in cases} == set(REGIONS)
    assert {case.sweep for case in cases} == {name}


@pytest.mark.parametrize("name", SWEEPS)
def test_no_case_may_pass_the_hard_limit_and_a_slow_body_not_much_more_than_the_threshold(name):
    limits = shipped_force_limits()
    for case in choose_cases(name):
        region = limits.region(case.region)
        most = 1.2 * region.retract if case.body_speed <= SLOW else region.hard_stop
        assert case.bound == min(most, region.hard_stop)


def test_a_face_bears_less_than_five_newton_at_walking_pace_of_a_hand():
    assert Push("Face_skin", 0.02, False).bound == pytest.approx(4.8)
    assert Push("Face_skin", 0.2, False).bound == 8.0


def test_cases_are_chosen_by_name_and_by_pattern():
    assert [case.name for case in choose_cases("pushes", ["rest-face-20", "scrub-hand-5"])] == [
        "rest-face-20", "scrub-hand-5",
    ]  # fmt: skip
    assert len(choose_cases("pushes", ["rest-*"])) == 27
    with pytest.raises(InputError, match="rest-nose-20"):
        choose_cases("pushes", ["rest-nose-20"])
    with pytest.raises(InputError, match="pushes, leans, paths"):
        choose_cases("shoves")


def outcome(case="rest-face-20", seed=0, peak=3.0, bound=4.8):
    row, _, column = case.rpartition("-")
    return Outcome(case, row, column, seed, peak, bound, "HOLD", "retracted")


def test_the_worst_trial_decides_and_its_seed_is_told():
    summary = summarise("pushes", [outcome(), outcome(seed=7, peak=5.0), outcome("rest-face-5", peak=4.0)])
    assert out_of_bounds(summary) == ["rest-face-20: 5.0 N with seed 7, more than 4.8 N; 1 of 2 trials"]
    assert out_of_bounds(summarise("pushes", [outcome(), outcome(seed=7, peak=4.8)])) == []


def test_the_table_has_a_column_for_each_speed_in_order_and_marks_what_is_out_of_bounds():
    trials = [outcome("rest-face-20", peak=9.0), outcome("rest-face-5"), outcome("scrub-face-100")]
    text = markdown(summarise("pushes", trials) | {"seeds": [0]})
    assert "| | 5 | 20 | 100 |" in text
    assert "| rest-face | 3.0 | **9.0** |  |" in text


@pytest.mark.parametrize(("peak", "code"), [(3.0, 0), (4.9, 1)])
def test_the_exit_code_is_0_only_when_nothing_was_out_of_bounds(monkeypatch, tmp_path, peak, code):
    monkeypatch.setattr(sweep_run, "run_all", lambda *_: [outcome(), outcome(seed=1, peak=peak)])
    console = Console(file=io.StringIO(), width=200)
    settings = SafetySweep("pushes", [0, 1], json_file=tmp_path / "a" / "s.json")
    assert sweep_safety(settings, console) == code
    assert (tmp_path / "a" / "s.json").exists()
    assert ("rest-face-20: 4.9 N with seed 1" in console.file.getvalue()) is (code == 1)


def test_options_of_the_other_evaluation_are_refused():
    assert name_list(" a, b,,") == ["a", "b"]
    refuse_with("--sweep", {"--faults": "", "--out": None})
    with pytest.raises(InputError, match="--faults means nothing with --sweep"):
        refuse_with("--sweep", {"--faults": "body_push", "--out": None})


def test_a_trial_can_be_run_again_by_its_name_and_seed():
    case = Push("Trunk_skin", 0.1, False)
    first, again = case.run(3), case.run(3)
    assert first == again
    assert first.case == "rest-trunk-100"
    assert 1.0 < first.peak_n <= first.bound_n == 12.0
