"""The measures of the fault matrix as laws on synthetic traces."""

import math

import numpy as np
import pytest
from bathbot_bringup.evaluation.safety.fault_table import Duty, Phase
from bathbot_bringup.evaluation.safety.measures import (
    Report,
    react,
    retract_begins,
    retract_delay,
)
from bathbot_bringup.sim.arm.controller.controller import STEP
from bathbot_bringup.sim.arm.trace import TraceData
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.arm.rm65 import RM65
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

ALONG, INTO = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])  # of the stroke, into the skin
START = 100.0  # [s] of the first sample; the fault strikes half a second later
FAULT = START + 0.5
KINEMATICS = RM65()


def trace_of(velocity, force=0.0, stamps=None, turn=None):
    """A trace with these velocities of the head [m/s], shape (N, 3), and forces [N], shape () or (N,)."""
    count = len(velocity)
    turn = np.eye(3) if turn is None else turn
    stamps = START + STEP * np.arange(count) if stamps is None else stamps
    forces = np.broadcast_to(force, count)
    return TraceData(
        stamp=stamps,
        joints=np.zeros((count, 6)),
        joint_speeds=np.linalg.norm(velocity, axis=1)[:, None] * np.ones(6),
        head=np.cumsum(velocity * STEP, axis=0) @ turn.T,
        approach=np.tile(turn @ INTO, (count, 1)),
        force=-forces[:, None] * (turn @ INTO),
        compression=np.where(forces > 0.0, 0.005, -0.01),
        indentation=np.zeros(count),
        pushed_force=np.array(forces, dtype=float),
        frame_stamp=np.zeros(0),
        frame_joints=np.zeros((0, 6)),
        event_stamp=np.zeros(0),
        event_kind=np.zeros(0, dtype=str),
        event_phase=np.zeros(0, dtype=str),
    )


def stroke(speed, stop, count=400, again=(), out=()):
    """Velocities of a stroke that ends `stop` samples after the fault, goes on or leaves in others."""
    velocity = np.zeros((count, 3))
    velocity[: 100 + stop] = speed * ALONG
    for first, last in again:
        velocity[first:last] = speed * ALONG
    for first, last in out:
        velocity[first:last] = -0.25 * INTO
    return velocity


def reaction(trace, phase=Phase.SCRUB, duty=Duty.STILL, reports=()):
    return react(trace, FAULT, phase, duty, reports)


@settings(deadline=None)
@given(speed=st.floats(0.02, 0.2), stop=st.integers(1, 200))
def test_the_stop_is_where_the_head_stands(speed, stop):
    found = reaction(trace_of(stroke(speed, stop)))
    assert found.stop == pytest.approx(stop * STEP, abs=1e-9)
    assert found.travel == pytest.approx(speed * stop * STEP, rel=1e-6)
    assert not found.moved_again


@settings(deadline=None)
@given(stop=st.integers(1, 100), pause=st.integers(10, 90), length=st.integers(1, 50))
def test_what_stands_and_moves_again_has_not_stopped(stop, pause, length):
    begin = 100 + stop + pause
    found = reaction(trace_of(stroke(0.05, stop, again=[(begin, begin + length)])))
    assert found.stop == pytest.approx((stop + pause + length) * STEP, abs=1e-9)
    assert found.moved_again


def test_what_never_stands_never_stops():
    found = reaction(trace_of(stroke(0.05, 300)))
    assert found.stop == math.inf
    assert found.detect == math.inf


def test_an_arm_at_rest_has_stopped_at_once():
    found = reaction(trace_of(np.zeros((400, 3)), force=2.0), Phase.REST)
    assert (found.stop, found.travel, found.peak) == (0.0, 0.0, 2.0)


@settings(deadline=None)
@given(stop=st.integers(1, 60), length=st.integers(10, 100))
def test_leaving_counts_as_stopped_and_then_standing_far_off_too(stop, length):
    velocity = stroke(0.05, stop, out=[(100 + stop, 100 + stop + length)])
    touching = np.arange(400) < 100 + stop
    for duty in Duty:
        found = reaction(trace_of(velocity, np.where(touching, 2.0, 0.0)), duty=duty)
        assert found.stop == pytest.approx(stop * STEP, abs=1e-9)


@settings(deadline=None)
@given(stop=st.integers(0, 100), out=st.integers(0, 100), length=st.integers(0, 60))
def test_who_must_leave_is_never_done_before_who_may_stand(stop, out, length):
    trace = trace_of(stroke(0.05, stop, out=[(100 + stop + out, 100 + stop + out + length)]), 2.0)
    still, leave = (reaction(trace, duty=duty) for duty in (Duty.STILL, Duty.LEAVE))
    assert leave.stop >= still.stop
    assert leave.peak == still.peak


def test_standing_on_the_skin_is_not_leaving():
    assert reaction(trace_of(np.zeros((400, 3)), 8.0), Phase.REST, Duty.LEAVE).stop == math.inf


@pytest.mark.parametrize(
    ("way", "calm"),
    [
        pytest.param(0.1 * ALONG, True, id="aside a little"),
        pytest.param(0.8 * ALONG, False, id="far aside"),
        pytest.param(0.1 * INTO, False, id="back to the skin"),
        pytest.param(0.02 * INTO, True, id="back a hair"),
    ],
)
def test_who_has_left_may_swing_but_neither_return_nor_wander(way, calm):
    velocity = stroke(0.05, 4, out=[(104, 184)])  # 0.1 m out
    velocity[184:224] = way
    found = reaction(trace_of(velocity, np.where(np.arange(400) < 104, 2.0, 0.0)), duty=Duty.LEAVE)
    assert (found.stop == pytest.approx(4 * STEP)) is calm


def test_in_free_air_the_way_back_is_the_way_it_came_and_no_other():
    velocity = np.zeros((400, 3))
    velocity[20:110], velocity[110:150] = 0.1 * ALONG, -0.1 * ALONG
    assert reaction(trace_of(velocity), Phase.TRANSIT).stop == pytest.approx(10 * STEP)
    velocity[110:150] = 0.1 * INTO
    assert reaction(trace_of(velocity), Phase.TRANSIT).stop == pytest.approx(50 * STEP)


@settings(deadline=None)
@given(seed=st.integers(0, 1000), stop=st.integers(1, 100))
def test_measures_do_not_depend_on_the_frame(seed, stop):
    turn = Rotation.random(random_state=seed).as_matrix()
    velocity = stroke(0.05, stop, out=[(130 + stop, 200 + stop)])
    plain, turned = (reaction(trace_of(velocity, 3.0, turn=matrix)) for matrix in (None, turn))
    assert turned.stop == plain.stop
    assert turned.travel == pytest.approx(plain.travel, rel=1e-9)
    assert turned.peak == pytest.approx(plain.peak, rel=1e-9)


@settings(deadline=None)
@given(gap=st.floats(0.11, 2.0), stop=st.integers(5, 100), at=st.integers(0, 4))
def test_time_in_which_the_controller_stood_is_not_the_arm_s(gap, stop, at):
    stamps = START + STEP * np.arange(400)
    stamps[101 + at :] += gap
    found = reaction(trace_of(stroke(0.05, stop), stamps=stamps))
    assert found.stop == pytest.approx(stop * STEP, abs=1e-9)


def test_signs_are_states_reasons_and_the_end_of_the_stream():
    trace = trace_of(stroke(0.05, 20))
    calm = Report(FAULT - 0.1, State.CONTACT, "waits", True)

    def detect(*reports, frames=()):
        told = trace._replace(frame_stamp=np.array(frames), frame_joints=np.zeros((len(frames), 6)))
        return reaction(told, reports=[calm, *reports]).detect

    assert detect(Report(FAULT + 0.1, State.CONTACT, "waits", True)) == math.inf
    assert detect(Report(FAULT + 0.1, State.CONTACT, "is late", True)) == pytest.approx(0.1)
    assert detect(Report(FAULT + 0.2, State.FAULT, "waits", True)) == pytest.approx(0.2)
    assert detect(Report(FAULT + 0.2, State.CONTACT, "waits", False)) == pytest.approx(0.2)
    assert detect(frames=[FAULT - 0.01, FAULT + 0.03]) == pytest.approx(0.03)
    alive = Report(FAULT + 1.0, State.CONTACT, "", True)
    assert detect(alive, frames=[FAULT - 0.01, FAULT + 0.03]) == math.inf
    assert detect(frames=[FAULT, trace.stamp[-1]]) == math.inf


def frames(distances):
    """Frames of the stream at 100 Hz whose head lies `distances` [m] outwards from a posture."""
    joints = np.radians([0.0, -40.0, -100.0, 0.0, 60.0, 0.0])
    found = []
    for distance in distances:
        for _ in range(3):  # Newton: straight outwards to a nanometre
            head, start = KINEMATICS.head(joints), KINEMATICS.head(np.radians([0, -40, -100, 0, 60, 0.0]))
            wanted = start[:3, 3] - distance * start[:3, 2]
            joints = joints + np.linalg.pinv(KINEMATICS.jacobian(joints)[:3]) @ (wanted - head[:3, 3])
        found.append(joints)
    return np.array(found)


@pytest.mark.parametrize("delay", [0, 1, 2, 5])
def test_a_retract_begins_with_its_first_frame_outwards(delay):
    begin = 55 + delay
    time = np.maximum(np.arange(80) - begin + 1, 0) * 0.01
    stream = frames(np.where(time < 0.0125, 400.0 * time**3 / 6.0, 2.0 * time**2))
    stamps = START + 0.01 * np.arange(80)
    pushed = np.where(np.arange(400) < 110, 2.0, 12.0)  # over the threshold 0.05 s after the fault
    trace = trace_of(np.zeros((400, 3)), pushed)._replace(frame_stamp=stamps, frame_joints=stream)
    assert retract_begins(trace, FAULT, KINEMATICS) == pytest.approx(stamps[begin])
    assert retract_delay(trace, FAULT, 10.0, KINEMATICS) == pytest.approx(0.01 * delay, abs=1e-9)
    assert math.isnan(retract_delay(trace, FAULT, 20.0, KINEMATICS))


def test_a_retract_that_never_came_has_no_end():
    trace = trace_of(np.zeros((400, 3)), 12.0)
    still = trace._replace(frame_stamp=START + 0.01 * np.arange(80), frame_joints=frames(np.zeros(80)))
    assert retract_delay(still, FAULT, 10.0, KINEMATICS) == math.inf
