"""The fault matrix: its table, the draw of trials, the summary, and one trial end to end."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.safety.fault_table import FAULTS, choose_faults
from bathbot_bringup.evaluation.safety.summary import out_of_bounds, percentile, summarise
from bathbot_bringup.evaluation.safety.table import markdown
from bathbot_bringup.evaluation.safety.trial.fault_injection import Ordered
from bathbot_bringup.evaluation.safety.trial.stroke_player import AHEAD, Progress, StrokePlayer, spoilt
from bathbot_bringup.evaluation.safety.trial.trial_site import find_site, seen_skin
from bathbot_bringup.evaluation.safety.trial_plan import Duty, Phase
from bathbot_bringup.evaluation.safety.trial_result import TrialResult
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_bringup.sim.faults.kinds import KINDS
from bathbot_bringup.sim.scenario import load_scenario
from bathbot_bringup.sim.scene import BathroomScene, true_camera_pose
from bathbot_scrub.rm65.arm.rm65 import RM65
from hypothesis import given, settings
from hypothesis import strategies as st

NAMES = [case.name for case in FAULTS]


def result(fault="lost_udp", seed=0, stop=100.0, **changes):
    values = {"phase": "scrub", "value": math.nan, "stop_ms": stop, "deadline_ms": 250.0, "detect_ms": 50.0,
              "retract_ms": math.nan, "travel_mm": 3.0, "peak_n": 2.0, "force_bound_n": 15.0,
              "moved_again": False, "missed": stop > 250.0, "attempts": 1, "said": ""}  # fmt: skip
    return TrialResult(fault, seed, **values | changes)


def test_every_row_names_a_fault_that_can_be_ordered():
    assert len(set(NAMES)) == len(NAMES) >= 15
    for case in FAULTS:
        if isinstance(case.injection, Ordered):
            assert case.injection.kind in KINDS
            for seed in range(20):
                value = case.plan(seed).value
                Fault(case.injection.kind, 0.0, case.injection.lasting(value), case.injection.order(value))


@pytest.mark.parametrize("case", FAULTS, ids=NAMES)
def test_trials_are_drawn_by_fault_and_seed_alone(case):
    plans = [case.plan(seed) for seed in range(20)]
    assert str(plans) == str([case.plan(seed) for seed in range(20)])
    assert len({plan.delay for plan in plans}) == 20
    assert {plan.phase for plan in plans} == set(case.phases)
    assert all(np.hypot(*plan.shift) <= 0.4 and 0.0 <= plan.offset < 0.01 for plan in plans)


def test_faults_are_chosen_by_name_and_a_wrong_one_is_explained():
    assert choose_faults() == list(FAULTS)
    assert [case.name for case in choose_faults(["lost_udp", "body_push"])] == ["body_push", "lost_udp"]
    with pytest.raises(InputError, match="did you mean lost_udp"):
        choose_faults(["lost_upd"])


@settings(deadline=None)
@given(st.lists(st.floats(0.0, 1e4), min_size=1, max_size=50), st.floats(0.01, 1.0))
def test_a_percentile_is_one_of_the_values_and_rises_with_its_share(values, share):
    found = percentile(values, share)
    assert found in values
    assert np.mean(np.asarray(values) <= found) >= share - 1e-9
    assert percentile(values, 1.0) == max(values)
    assert percentile([*values, math.inf], 1.0) == math.inf


def test_the_summary_counts_what_is_out_of_bounds():
    trials = [
        result(stop=100.0),
        result(seed=1, stop=300.0, moved_again=True),
        result("body_push", retract_ms=8.0, peak_n=16.0),
        result("body_push", 1, retract_ms=12.0),
        result("frozen_force", stop=math.inf, detect_ms=math.inf),
    ]
    summary = summarise(trials, [{"fault": "nan_force", "seed": 3, "reason": "no contact"}])
    rows = {row["name"]: row for row in summary["faults"]}
    assert (rows["lost_udp"]["missed"], rows["lost_udp"]["stop_ms_p50"]) == (1, 100.0)
    assert rows["frozen_force"]["undetected"] == 1
    assert (summary["retract_ms_p99"], summary["retract_ms_max"], summary["retracts"]) == (12.0, 12.0, 2)
    found = "\n".join(out_of_bounds(summary))
    for complaint in (
        "nan_force, seed 3: no contact",
        "lost_udp: missed in 1 of 2",
        "body_push: 16.0 N, more",
        "frozen_force: stop inf ms",
        "retract_ms_p99: 12.0 ms",
    ):
        assert complaint in found
    assert out_of_bounds(summarise([result()], [])) == []
    text = markdown(summary | {"machine": {"cores": 2, "cpu": "x", "load": 0.5}, "jobs": 1, "seconds": 60.0})
    assert "| frozen_force | the force sensor repeats one reading | 1 | **1** |" in text


def test_the_planner_keeps_its_pieces_ahead_and_the_stroke_closes():
    stroke = np.tile(np.eye(4), (24, 1, 1))
    stroke[:, 0, 3] = np.arange(24)
    player, sent = StrokePlayer(5, "Trunk_skin", stroke, 0.05), []
    while (segment := player.due(None)) is not None:
        sent.append(segment)
    assert [segment.index for segment in sent] == list(range(AHEAD))
    assert player.due(Progress(4, 9, False)) is None  # of another path
    sent.append(player.due(Progress(5, 1, False)))
    along = np.concatenate([segment.T_base_heads[:, 0, 3] for segment in sent])
    assert along.tolist() == (np.arange(len(along)) % 24).tolist()
    assert np.isnan(spoilt(sent[0]).T_base_heads[:, :3, 3]).all()


def test_a_site_is_skin_all_about_and_a_stroke_follows_it():
    surface = BathroomScene(0).surface(load_scenario("still"))
    site = find_site(surface, true_camera_pose(), RM65())
    target = site.target((0.01, -0.01), 1.0)
    poses = site.stroke(target, 0.5 * site.room, 0.002, 0.004)
    origins = poses[:, :3, 3] - 0.05 * poses[:, :3, 2]
    distances, _, part = surface.distance(origins, poses[:, :3, 2], 0.0)
    np.testing.assert_allclose(distances, 0.046, atol=1e-5)  # [m]: 4 mm deep
    assert part == "Trunk_skin"
    skin = seen_skin(surface, target)
    assert np.isfinite(skin).all(axis=-1).mean() > 0.5
    aims = np.tile(target[:3, 2], (skin[..., 0].size, 1))
    met, _, _ = surface.distance(skin.reshape(-1, 3) - 0.01 * aims, aims, 0.0)
    np.testing.assert_allclose(met[np.isfinite(met)], 0.01, atol=1e-4)
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0, append=poses[:1, :3, 3]), axis=1)
    assert steps.max() < 0.004  # [m] also where the stroke closes


@pytest.mark.graph
def test_one_fault_end_to_end(tmp_path: Path):
    """Real processes, DDS, TCP and UDP; only what happens is asserted, not how fast."""
    files = {name: tmp_path / f"safety.{name}" for name in ("json", "md", "png")}
    seed = next(
        seed for seed in range(9) if choose_faults(["dropped_tcp"])[0].plan(seed).phase is Phase.TRANSIT
    )
    outputs = ["--json", str(files["json"]), "--markdown", str(files["md"]), "--picture", str(files["png"])]
    code = run(["evaluate", "safety", "--seeds", str(seed), "--faults", "dropped_tcp", *outputs])
    summary = json.loads(files["json"].read_text(encoding="utf-8"))
    assert code in (0, 1)
    assert summary["failed"] == []
    (row,) = summary["faults"]
    assert {"name", "trials", "missed", "stop_ms_p50", "stop_ms_p95", "stop_ms_max", "overshoot_n_max",
            "travel_mm_max"} <= set(row)  # fmt: skip
    assert (row["name"], row["trials"], row["undetected"]) == ("dropped_tcp", 1, 0)
    assert row["travel_mm_max"] < 100.0
    (trial,) = summary["results"]
    assert re.search("connection", trial["said"])
    assert "| dropped_tcp |" in files["md"].read_text(encoding="utf-8")
    assert files["png"].stat().st_size > 1000


@pytest.mark.parametrize(
    "arguments",
    [
        ["--jobs", "0"],
        ["--faults", "flood"],
        ["--seeds", "x"],
        ["--cases", "rest-*"],
        ["--sweep", "shoves"],
        ["--sweep", "pushes", "--jobs", "0"],
        ["--sweep", "pushes", "--cases", "rest-nose-20"],
        ["--sweep", "pushes", "--faults", "body_push"],
    ],
)
def test_bad_input_is_refused_before_anything_starts(arguments, capsys):
    assert run(["evaluate", "safety", *arguments]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_who_is_pushed_or_hurt_must_leave():
    leaving = {case.name for case in FAULTS if case.duty is Duty.LEAVE}
    assert leaving == {"body_push", "body_slow", "body_fast", "force_step"}


def test_a_body_may_use_up_the_bristles_before_the_deadline_begins_and_one_that_leans_in_has_none():
    slow, lean = (choose_faults([name])[0].injection for name in ("body_slow", "body_lean"))
    assert slow.deadline(0.005) == pytest.approx(2.25)  # [s]: 10 mm at 5 mm/s
    assert slow.lasting(0.005) == pytest.approx(10.0)
    assert (lean.deadline(0.1), lean.order(0.1), lean.lasting(0.1)) == (math.inf, 0.2, pytest.approx(0.5))
    assert choose_faults(["lost_udp"])[0].injection.deadline(math.nan) == 0.25


def test_speeds_of_a_body_are_drawn_evenly_by_their_logarithm():
    speeds = [choose_faults(["body_slow"])[0].plan(seed).value for seed in range(400)]
    assert min(speeds) < 0.006 < 0.09 < max(speeds) <= 0.1
    assert np.median(speeds) == pytest.approx(np.sqrt(0.005 * 0.1), rel=0.15)
