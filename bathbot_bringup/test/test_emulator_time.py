"""When the emulator does things: the beat of the push, what a stall leaves, and how a dead stream ends.

Time is that of the emulator's own trace; what a busy machine cannot do is told in `late`.
"""

import gc
import socket
import time

import numpy as np
import pytest
from bathbot_bringup.sim.arm.controller.controller import STEP
from bathbot_bringup.sim.arm.emulator.bathroom import bathroom_emulator
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.node_settings import SimRm65Settings
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.protocol import encode, joints_to_wire
from command_examples import READY, desk_at, run
from emulator_cell import until
from numpy.testing import assert_allclose

pytestmark = pytest.mark.graph

STANDSTILL = 0.01  # [rad/s]


@pytest.fixture(scope="module")
def emulator():
    with Emulator(EmulatorSettings(port=0, joints_deg=tuple(np.degrees(READY)))) as emulator:
        yield emulator


def test_the_beat_is_200_hz(emulator):
    late = emulator.late
    emulator.trace.clear()
    until(lambda: len(emulator.trace.data().stamp) > 300)
    data = emulator.trace.data()
    elapsed = data.stamp[-1] - data.stamp[0]
    rate = (len(data.stamp) - 1) / elapsed
    assert rate == pytest.approx(200.0, abs=2.0) or emulator.late > late
    missing = np.isnan(data.pushed_force).sum()
    assert missing <= emulator.late - late + 2


def test_a_stall_is_made_up_for_without_a_burst(emulator):
    emulator.trace.clear()
    late = emulator.late
    with emulator._lock:  # as if the machine stood still
        time.sleep(0.25)
    until(lambda: len(emulator.trace.data().stamp) > 80)
    data = emulator.trace.data()
    gap = int(np.argmax(np.diff(data.stamp)))
    assert emulator.late - late >= 40
    assert data.stamp[gap + 1] - data.stamp[gap] > 0.2
    after = data.stamp[gap + 1 :] - data.stamp[gap + 1]
    pushed = np.isfinite(data.pushed_force[gap + 1 :])
    assert pushed[after < 0.02].sum() <= 8


def streamed(desk, speed, seconds=0.6):
    """Let the head go along y at a speed [m/s] by a stream of 100 Hz that dies; joints of its last frame."""
    arm, joints = RM65("6F"), READY.copy()
    for _ in range(round(seconds / 0.01)):
        twist = np.array([0.0, speed, 0.0, 0.0, 0.0, 0.0])
        joints = joints + 0.01 * np.linalg.solve(arm.jacobian(joints), twist)
        desk.controller.stream(joints)
        run(desk, 0.01)
    return joints


@pytest.mark.parametrize(
    ("speed", "within", "farther"), [(0.05, 0.08, 0.002), (0.10, 0.17, 0.005), (0.25, 0.26, 0.012)]
)
def test_an_arm_whose_stream_dies_comes_to_rest_by_itself(speed, within, farther):
    """As docs/emulator.md says: within 0.08 s, 0.17 s and 0.26 s, and 2, 5 and 12 mm."""
    desk = desk_at()
    last = streamed(desk, speed)
    place = desk.controller.T_base_head[:3, 3]
    joints, speeds, ends = run(desk, 0.5)
    moving = np.flatnonzero(np.abs(speeds).max(1) > STANDSTILL)
    assert (moving[-1] + 1) * STEP <= within
    ways = RM65("6F").head(joints)[:, :3, 3] - place
    assert np.linalg.norm(ways, axis=1).max() < farther
    assert_allclose(joints[-1], last, atol=1e-4)
    assert ends == []


def test_a_client_that_dies_while_it_streams_leaves_the_arm_at_rest_near_its_last_frame(emulator):
    raw = socket.create_connection(("127.0.0.1", emulator.port))
    joints = emulator.truth().joints.copy()
    for _ in range(30):
        joints[0] += 0.005
        raw.sendall(encode({"command": "movej_canfd", "joint": joints_to_wire(joints), "follow": True}))
        time.sleep(0.01)
    raw.sendall(b'{"command": "movej_canfd", "jo')
    raw.close()
    until(lambda: np.abs(emulator.truth().joints - joints).max() < 1e-4)
    until(lambda: not emulator.sessions)
    data = emulator.trace.data()
    after = data.stamp > data.frame_stamp[-1] + 0.3
    assert np.abs(data.joint_speeds[after]).max(initial=0.0) < STANDSTILL


def test_what_is_loaded_is_kept_out_of_the_collection_of_memory():
    with bathroom_emulator(SimRm65Settings(port=0, person=False)):
        aside = gc.get_freeze_count()
        gc.unfreeze()
    assert aside > 10_000
