"""From when a reaction counts, on synthetic traces."""

import numpy as np
import pytest
from bathbot_bringup.evaluation.safety.trial.fault_injection import Injected, Nearer, Ordered, SilentPlanner
from bathbot_bringup.evaluation.safety.trial.stroke_player import LastPose
from bathbot_bringup.evaluation.safety.trial.trial_run import SpoiltTrialError
from bathbot_bringup.sim.arm.trace import TraceData

STAMPS = 10.0 + 0.005 * np.arange(1000)


def trace_of(along, force=0.0, events=()):
    """A trace of a head at places `along` y [m], shape (1000,), with forces [N] and begun faults."""
    empty = {name: np.zeros(0) for name in TraceData._fields}
    head = np.stack([np.zeros(1000), along, np.zeros(1000)], axis=-1)
    pressed = np.stack([np.zeros(1000), np.zeros(1000), np.broadcast_to(force, 1000)], axis=-1)
    return TraceData(
        **empty
        | {
            "stamp": STAMPS,
            "head": head,
            "force": pressed,
            "event_stamp": np.array([stamp for stamp, _ in events]),
            "event_kind": np.array([kind for _, kind in events], dtype=str),
            "event_phase": np.array(["begin"] * len(events), dtype=str),
        }
    )


def test_an_ordered_fault_begins_when_the_emulator_says_so():
    trace = trace_of(np.zeros(1000), events=[(10.5, "lost_udp"), (11.0, "joint_error")])
    assert Ordered("joint_error").onset(Injected(10.9), trace) == 11.0
    with pytest.raises(SpoiltTrialError, match="did not begin the fault power_cut"):
        Ordered("power_cut").onset(Injected(10.9), trace)


def test_a_nearer_body_counts_from_what_is_felt():
    force = np.maximum(STAMPS - 11.0, 0.0)  # [N], one more each second
    found = Nearer(0.02).onset(Injected(10.0), trace_of(np.zeros(1000), force))
    assert found == pytest.approx(12.0, abs=0.006)


def test_a_path_ends_where_the_head_stays_not_where_it_passes_by():
    along = 0.03 * np.minimum(STAMPS - 10.0, 3.0)  # 30 mm/s, and from 13.0 s on at rest
    there_and_back = np.where(STAMPS < 12.0, along, 0.06 - 0.03 * np.clip(STAMPS - 12.0, 0.0, 1.0))
    end = LastPose(10.2, np.array([0.0, 0.03, 0.0]), 1)  # passed at 11.0 s, reached for good at 13.0 s
    found = SilentPlanner().onset(Injected(10.3, path_end=end), trace_of(there_and_back))
    assert found == pytest.approx(13.0 - 0.002 / 0.03, abs=0.006)
    beyond = LastPose(10.2, np.array([0.0, 0.09, 0.0]), 1)
    with pytest.raises(SpoiltTrialError, match="did not run out"):
        SilentPlanner().onset(Injected(10.3, path_end=beyond), trace_of(there_and_back))
