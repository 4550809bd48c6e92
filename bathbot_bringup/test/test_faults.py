"""Faults as they are written, when they last, and the trace that tells of them."""

import math
import time
from pathlib import Path

import numpy as np
import pytest
from bathbot_bringup.errors import InputError, SettingsError
from bathbot_bringup.sim.arm.emulator.surface import PlaneSurface
from bathbot_bringup.sim.arm.trace import Trace, load_trace
from bathbot_bringup.sim.faults import kinds
from bathbot_bringup.sim.faults.fault_schedule import FaultEvent, FaultSchedule
from bathbot_bringup.sim.faults.faults import Fault, parse_fault, read_fault
from bathbot_bringup.sim.faults.force_faults import ForceHistory, ForceReading
from bathbot_bringup.sim.faults.kinds import KINDS
from bathbot_bringup.sim.faults.lasting_fault import Place
from bathbot_bringup.sim.faults.push_faults import Datagram, Outbox
from bathbot_bringup.sim.faults.pushed_surface import BodyStep, PushedSurface
from bathbot_bringup.sim.scenario import load_scenario
from bathbot_depthcorr.geometry.rigid import transform_from
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

LENIENT = settings(
    max_examples=50, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)  # the machine may be busy
LASTING = sorted(set(KINDS) - {"none"})


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_alone_is_a_fault_with_its_own_value(kind):
    assert KINDS[kind].about
    fault = parse_fault({"kind": kind})
    assert (fault.after, fault.duration) == (0.0, math.inf)
    assert_allclose(fault.value, KINDS[kind].value)


@LENIENT
@given(
    mapping=st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(["kind", "after", "duration", "value"]) | st.text(max_size=3), inner
            )
        ),
        max_leaves=8,
    )
    | st.fixed_dictionaries(
        {"kind": st.sampled_from(sorted(KINDS))},
        optional={key: st.floats() | st.integers() | st.text() for key in ("after", "duration", "value")},
    )
)
def test_whatever_is_written_is_a_fault_or_one_line(mapping):
    try:
        fault = parse_fault(mapping)
    except SettingsError as error:
        told = str(error)
        assert "\n" not in told
    else:
        kind = KINDS[fault.kind]
        assert 0.0 <= fault.after < math.inf
        assert fault.duration > 0.0
        assert math.isnan(kind.value) or kind.lowest <= fault.value <= kind.highest


@pytest.mark.parametrize("text", ["", "{", "[" * 600, "kind: tea", "\0", "- 1", "{kind: lost_udp, value: 3}"])
def test_text_that_is_no_fault_is_refused(text):
    with pytest.raises(SettingsError):
        read_fault(text)
    assert read_fault("{kind: slow_udp, after: 1, value: 0.5}") == Fault("slow_udp", 1.0, value=0.5)


@LENIENT
@given(
    orders=st.lists(
        st.tuples(st.sampled_from(LASTING), st.floats(0.0, 5.0), st.floats(0.01, 5.0)), max_size=8
    ),
    steps=st.lists(st.floats(0.001, 3.0), min_size=1, max_size=20),
)
def test_every_fault_begins_once_and_ends_once_in_time(orders, steps):
    schedule = FaultSchedule()
    for kind, after, duration in orders:
        schedule.order(Fault(kind, after, duration), now=100.0)
    events, now = [], 100.0
    for step in [*steps, 20.0, 20.0]:
        now += step
        events += schedule.update(now)
        for kind in LASTING:
            begun = sum(e.kind == kind and e.phase == "begin" for e in events)
            ended = sum(e.kind == kind and e.phase == "end" for e in events)
            assert (kind in schedule) == (begun > ended)
    assert sorted(e.kind for e in events if e.phase == "begin") == sorted(kind for kind, _, _ in orders)
    assert sorted(e.kind for e in events if e.phase == "end") == sorted(kind for kind, _, _ in orders)


def test_none_ends_all_and_forgets_what_waits():
    schedule = FaultSchedule()
    schedule.order(Fault("lost_udp"), 0.0)
    schedule.order(Fault("nan_force", after=2.0), 0.0)
    assert schedule.update(0.0) == [FaultEvent(0.0, "lost_udp", "begin")]
    schedule.order(Fault("none"), 1.0)
    assert schedule.update(1.0) == [FaultEvent(1.0, "lost_udp", "end"), FaultEvent(1.0, "none", "begin")]
    assert schedule.update(9.0) == []
    assert "lost_udp" not in schedule
    assert schedule.at(Place.PUSH) == []


def lasting(*orders):
    """A schedule in which these faults have begun."""
    schedule = FaultSchedule()
    for order in orders:
        schedule.order(order, 0.0)
    schedule.update(0.0)
    return schedule


@pytest.mark.parametrize("kind", LASTING)
def test_a_row_names_its_places_and_only_they_see_the_fault(kind):
    schedule, row = lasting(Fault(kind)), KINDS[kind]
    assert row.acts
    for place in Place:
        acts = [row.acts[place]] if place in row.acts else []
        assert [fault.act for fault in schedule.at(place)] == acts
        for act in acts:
            assert act.__module__.endswith(f".{place.value}") or kind in ("power_cut", "stalled")


def test_no_place_knows_a_fault_by_name():
    """Ask `sim/faults/kinds.py` for a kind: its name stands nowhere else in the simulator."""
    folder = Path(kinds.__file__).parents[1]
    named = [
        (file.name, kind)
        for file in folder.rglob("*.py")
        if file != Path(kinds.__file__)
        for kind in LASTING
        if f'"{kind}"' in file.read_text(encoding="utf-8")
    ]
    assert named == []


def said(schedule, history, reading):
    """What a force sensor says of a true reading."""
    history.keep(reading)
    for fault in schedule.at(Place.FORCE_SENSOR):
        reading = fault(reading, history)
    return reading


def reading(z):
    return ForceReading(np.full(6, float(z)), np.full(6, -float(z)))


def test_a_stale_force_is_the_one_of_some_time_ago():
    history, readings = ForceHistory(0.005), [reading(index) for index in range(300)]
    for true in readings[:200]:
        assert said(FaultSchedule(), history, true) is true
    schedule = lasting(Fault("stale_force", value=0.5))
    for index in range(200, 300):
        assert said(schedule, history, readings[index]) is readings[index - 100]


def test_faults_of_one_sensor_add_up_and_a_gone_one_says_nothing_else():
    history = ForceHistory(0.005)
    schedule = lasting(Fault("biased_force", value=-3.0), Fault("drifting_force", value=2.0))
    found = [said(schedule, history, reading(1.0)) for _ in range(10)]
    assert_allclose([entry.raw[2] for entry in found], 1.0 - 3.0 + 0.01 * np.arange(1, 11))
    assert_allclose(found[-1].zero[[0, 2]], [-1.0, -1.0 - 3.0 + 0.1])
    schedule.order(Fault("dead_force"), 1.0)
    schedule.update(1.0)
    gone = said(schedule, history, reading(1.0))
    assert (gone.error, np.abs(gone.raw).max()) == (0x2003, 0.0)


def test_a_fault_forgets_when_it_ends():
    history, schedule = ForceHistory(0.005), lasting(Fault("frozen_force", duration=1.0))
    assert said(schedule, history, reading(1.0)).raw[2] == 1.0
    schedule.order(Fault("nan_force", duration=0.1), 0.5)
    schedule.update(0.5)  # what goes on keeps its memory
    schedule.update(0.7)
    assert said(schedule, history, reading(2.0)).raw[2] == 1.0
    schedule.update(1.5)
    schedule.order(Fault("frozen_force"), 2.0)
    schedule.update(2.0)
    assert said(schedule, history, reading(3.0)).raw[2] == 3.0


def test_datagrams_that_were_held_back_leave_in_order_when_the_fault_ends():
    outbox, schedule = Outbox(), lasting(Fault("time_jump", value=0.095))
    states = [Datagram(str(index).encode(), float(index)) for index in range(40)]
    left = [
        outbox.leaving(state, 0.01 * index, schedule.at(Place.PUSH)) for index, state in enumerate(states)
    ]
    assert [len(group) for group in left if group] == [11, 11, 11]
    rest = outbox.leaving(Datagram(b"last", 40.0), 0.4, [])
    assert [one for group in [*left, rest] for one in group][:40] == states
    assert len(rest) == 8


def test_the_page_about_the_emulator_names_every_kind():
    page = (Path(__file__).parents[2] / "docs" / "emulator.md").read_text(encoding="utf-8")
    assert not [kind for kind in KINDS if f"`{kind}`" not in page]


@LENIENT
@given(tilt=st.floats(-0.4, 0.4), depth=st.floats(0.001, 0.02), speed=st.floats(0.01, 1.0))
def test_a_pressed_body_moves_along_its_normal_and_not_too_far(tilt, depth, speed):
    normal = np.array([-np.cos(tilt), np.sin(tilt), 0.0])
    surface = PushedSurface(PlaneSurface(tuple(normal), float(normal @ (0.5, 0.0, 0.3))))
    head = transform_from(Rotation.from_euler("y", 90, degrees=True).as_matrix(), (0.5 + depth, 0.0, 0.3))
    (push,) = lasting(Fault("body_push", value=speed)).at(Place.BODY)
    for _ in range(20):
        push(surface, BodyStep(head, 0.0, True, 0.005))
    assert_allclose(surface.offset, 0.1 * speed * normal, atol=1e-9)
    for _ in range(1000):
        push(surface, BodyStep(head, 0.0, True, 0.005))
    assert np.linalg.norm(surface.offset) <= 0.3
    surface.put_back()
    assert_allclose(surface.offset, 0.0)


def test_a_scenario_orders_faults(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text("sway_amplitude: 0.001\nfaults: [{kind: lost_udp, after: 2.0, duration: 0.5}]\n")
    assert load_scenario(str(path)).faults == (Fault("lost_udp", 2.0, 0.5),)
    path.write_text("faults: [{kind: tea}]\n")
    with pytest.raises(SettingsError, match="known are none, stale_force"):
        load_scenario(str(path))


def test_the_trace_keeps_the_newest_and_reads_as_it_was_written(tmp_path):
    trace = Trace(kept=300)
    for index in range(700):
        trace.step([float(index), *range(6), *range(6, 12), *range(12, 21), 21.0, 22.0, math.nan])
        trace.frame(index + 0.5, np.full(6, index))
    trace.events([FaultEvent(3.0, "lost_udp", "begin"), FaultEvent(4.0, "lost_udp", "end")])
    trace.write(tmp_path / "deep" / "trace.npz")
    data = load_trace(tmp_path / "deep" / "trace.npz")
    assert_allclose(data.stamp, np.arange(400.0, 700.0))
    assert_allclose(data.joint_speeds[7], range(6, 12))
    assert_allclose(data.approach[0], [15, 16, 17])
    assert (data.compression[0], data.indentation[0]) == (21.0, 22.0)
    assert np.isnan(data.pushed_force).all()
    assert_allclose(data.frame_joints[:, 2], data.frame_stamp - 0.5)
    assert (data.event_kind.tolist(), data.event_phase.tolist()) == (["lost_udp"] * 2, ["begin", "end"])
    trace.clear()
    trace.step([9.0] * 25)
    assert trace.data().stamp.tolist() == [9.0]
    assert not len(trace.data().event_kind)


def test_what_is_no_trace_is_refused(tmp_path):
    (tmp_path / "x.npz").write_text("tea")
    np.savez(tmp_path / "y.npz", stamp=np.zeros(3))
    for name in ("x.npz", "y.npz", "none.npz"):
        with pytest.raises(InputError, match="is no trace"):
            load_trace(tmp_path / name)
    with pytest.raises(InputError, match="cannot write trace"):
        Trace(kept=1).write("/proc/no/trace.npz")
    with pytest.raises(InputError, match="choose another name"):
        Trace(kept=1).write(tmp_path / "x.yaml")


def test_a_step_of_the_trace_costs_little():
    trace, row = Trace(), [1.0] * 25
    begun = time.perf_counter()
    for _ in range(1000):
        trace.step(row)
    assert (time.perf_counter() - begun) / 1000 < 1e-3  # 3 us on a quiet machine
