"""What each ordered fault does to a running emulator, seen through its wire and its trace."""

import socket
import time

import numpy as np
import pytest
from bathbot_bringup.sim.arm.commands.table import reply
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_scrub.arm.errors import ArmConnectionError, RefusedError
from bathbot_scrub.rm65.controller.client import ArmClient
from bathbot_scrub.rm65.controller.protocol import encode
from bathbot_scrub.rm65.controller.state_push import StateReceiver
from command_examples import EXAMPLES, JOINTS, desk_at, run
from emulator_cell import AXIS, READY_DEG, TARGET, Wall, until
from numpy.testing import assert_allclose

pytestmark = pytest.mark.graph

READY = np.radians(READY_DEG)


class Bench:
    """An emulator, a client of its TCP, a receiver of its push."""

    def __init__(self):
        self.wall, self.samples = Wall(), []
        self.emulator = Emulator(EmulatorSettings(port=0, joints_deg=READY_DEG), self.wall)
        self.client = ArmClient("127.0.0.1", self.emulator.port)
        self.client.start()
        until(lambda: self.client.connection.connected)
        self.receiver = StateReceiver(0, self.samples.append)
        self.receiver.expect("127.0.0.1")
        self.demand({"command": "set_realtime_push", "port": self.receiver.port}, "state")
        until(lambda: self.samples)

    def order(self, kind, **values):
        """Let something fail, and wait until it does."""
        self.emulator.order(Fault(kind, **values))
        until(lambda: kind in self.emulator.faults)

    def healthy(self):
        """End all faults; the samples before do not count."""
        count = len(self.emulator.trace.data().event_kind)
        self.emulator.order(Fault("none"))
        until(lambda: "none" in self.emulator.trace.data().event_kind[count:])

    def after(self, count=8):
        """Samples that come from now on; the first may have been on its way."""
        begin = len(self.samples)
        until(lambda: len(self.samples) >= begin + count + 1)
        return self.samples[begin + 1 :]

    def steps(self, count):
        """Wait for steps of the arm's clock."""
        begin = len(self.emulator.trace.data().stamp)
        until(lambda: len(self.emulator.trace.data().stamp) >= begin + count)

    def query(self):
        return self.client.request({"command": "get_joint_degree"})

    def demand(self, frame, key):
        """Ask for something, patiently: the machine may be busy."""
        if self.client.request(frame, timeout=10.0).get(key) is not True:
            raise RefusedError(str(frame))

    def close(self):
        self.receiver.close()
        self.client.close()
        self.emulator.close()


@pytest.fixture(scope="module")
def module_bench():
    bench = Bench()
    yield bench
    bench.close()


@pytest.fixture
def bench(module_bench):
    yield module_bench
    module_bench.healthy()
    until(lambda: module_bench.client.connection.connected)
    module_bench.demand({"command": "clear_system_err"}, "clear_state")
    module_bench.demand({"command": "set_arm_power", "arm_power": 1}, "arm_power")
    module_bench.after()


def forces(samples):
    return np.array([sample.wrench[:3] for sample in samples])


def test_a_frozen_force_repeats_itself_and_a_healthy_one_never(bench):
    assert len(np.unique(forces(bench.after()), axis=0)) > 6
    bench.order("frozen_force")
    assert len(np.unique(forces(bench.after()), axis=0)) == 1


@pytest.mark.parametrize(
    ("kind", "value", "felt"), [("biased_force", -12.0, -12.0), ("saturated_force", -150.0, -150.0)]
)
def test_a_wrong_force_is_wrong_by_its_value(bench, kind, value, felt):
    bench.steps(25)  # zeroing averages twenty readings
    bench.demand({"command": "clear_force_data"}, "clear_state")
    bench.order(kind, value=value)
    assert_allclose(forces(bench.after())[-5:, 2], felt, atol=3.0)


def test_a_drifting_force_drifts(bench):
    bench.order("drifting_force", value=-40.0)
    drift = forces(bench.after(40))[:, 2]
    assert drift[-1] < drift[0] - 4.0


def test_a_force_that_is_no_number_is_null_and_its_joints_count_all_the_same(bench):
    bench.order("nan_force")
    until(lambda: np.isnan(bench.receiver.latest.wrench).all())
    assert np.isfinite(bench.receiver.latest.joints).all()
    assert bench.client.request({"command": "get_force_data"}, timeout=10.0)["zero_force_data"] == [None] * 6
    bench.demand({"command": "clear_force_data"}, "clear_state")
    bench.healthy()
    assert np.isfinite(forces(bench.after())).all()


def test_a_dead_sensor_is_an_error_of_the_system(bench):
    bench.order("dead_force")
    assert bench.after()[-1].errors == (0x2003,)


def test_a_lost_push_is_silent_and_the_trace_says_so(bench):
    bench.order("lost_udp")
    bench.steps(2)
    count = len(bench.samples)
    bench.steps(40)
    assert len(bench.samples) <= count + 1
    assert np.isnan(bench.emulator.trace.data().pushed_force[-30:]).all()


def test_a_slow_push_is_slow(bench):
    bench.order("slow_udp", value=0.05)
    bench.steps(70)
    pushed = np.isfinite(bench.emulator.trace.data().pushed_force[-60:])
    assert 3 <= pushed.sum() <= 7


def test_a_frozen_push_repeats_all_of_it(bench):
    bench.order("frozen_udp")
    samples = bench.after()
    assert len({(*sample.joints, *sample.wrench) for sample in samples}) == 1


def test_a_garbled_push_is_refused(bench):
    bench.order("garbled_udp")
    rejected = bench.receiver.rejected
    until(lambda: bench.receiver.rejected > rejected + 5)


def test_after_a_time_jump_all_comes_at_once(bench):
    bench.order("time_jump", value=0.12)
    stamps = np.array([sample.stamp for sample in bench.after(60)])
    gaps = np.diff(stamps)
    assert (gaps > 0.06).any()
    assert np.median(gaps) < 0.002


def test_dropped_clients_come_back_when_it_is_over(bench):
    bench.order("dropped_tcp", duration=0.2)
    until(lambda: not bench.client.connection.connected)
    until(lambda: "dropped_tcp" not in bench.emulator.faults)
    until(lambda: bench.client.connection.connected)
    until(lambda: len(bench.emulator.sessions) == 1)
    bench.query()


def test_a_slow_controller_answers_late_but_all(bench):
    bench.order("slow_reply", value=0.6)
    with pytest.raises(ArmConnectionError, match="no reply"):
        bench.query()
    begun = time.monotonic()
    bench.client.request({"command": "get_joint_max_pos"}, timeout=10.0)
    assert time.monotonic() - begun >= 0.5


def test_a_deaf_controller_takes_connections_and_says_nothing(bench):
    bench.order("deaf_tcp")
    with socket.create_connection(("127.0.0.1", bench.emulator.port), timeout=0.3) as probe:
        probe.sendall(encode({"command": "get_joint_degree"}))
        with pytest.raises(TimeoutError):
            probe.recv(10)
    bench.client.stream_joints(READY + 0.01)
    bench.steps(30)
    assert_allclose(bench.emulator.truth().joints, READY, atol=1e-6)


def move(bench, offset=(40, 0, 0, 0, 0, 0)):
    goal = [round(1000 * q) for q in np.add(READY_DEG, offset)]
    bench.demand(
        {"command": "movej", "v": 50, "joint": goal, "trajectory_connect": 0, "r": 0}, "receive_state"
    )
    until(lambda: np.abs(bench.emulator.truth().joints - READY).max() > 0.05)


def back(bench):
    """Home again, healthy."""
    bench.healthy()
    for frame, key in (({"command": "clear_system_err"}, "clear_state"),
                       ({"command": "set_arm_power", "arm_power": 1}, "arm_power")):  # fmt: skip
        bench.demand(frame, key)
    goal = [round(1000 * q) for q in READY_DEG]
    bench.demand({"command": "movej", "v": 100, "joint": goal}, "receive_state")
    until(lambda: np.abs(bench.emulator.truth().joints - READY).max() < 1e-3)
    until(lambda: bench.samples[-1].status == "idle")  # a planned move that still runs keeps streams out


@pytest.mark.parametrize(
    ("kind", "code", "joint_code"),
    [("joint_error", 0x1010, 0x40), ("following_error", 0x1010, 0x800), ("collision_stop", 0x100D, 0)],
)
def test_a_fault_of_the_arm_stops_it_and_the_stream_is_not_obeyed(kind, code, joint_code):
    desk, far = desk_at(), [40000, *JOINTS[1:]]
    controller = desk.controller
    reply(desk, EXAMPLES["movej"] | {"joint": far})
    run(desk, 0.3)
    controller.faults.order(Fault(kind) if kind == "collision_stop" else Fault(kind, value=1), 0.0)
    controller.faults.update(0.0)
    _, speeds, ends = run(desk, 0.5)
    assert (controller.health.error, controller.health.joint_codes[0]) == (code, joint_code)
    assert [end.reached for end in ends] == [False]
    assert np.abs(speeds[50:]).max() < 0.02  # 0.25 s
    stood = controller.dynamics.joints
    assert 0.01 < stood[0] < np.radians(39.0)
    controller.stream(stood + 0.02)
    assert_allclose(run(desk, 0.2)[0][-1], stood, atol=1e-3)
    controller.faults.order(Fault("none"), 0.0)
    controller.faults.update(0.0)
    assert_allclose(run(desk, 0.2)[0][-1], stood, atol=1e-3)
    reply(desk, EXAMPLES["clear_system_err"])
    assert controller.health.error == 0
    assert reply(desk, EXAMPLES["movej"])["receive_state"]
    assert [end.reached for end in run(desk, 3.0)[2]] == [True]


def test_a_power_cut_brakes_hard_and_silences_all_until_power_is_switched_on(bench):
    move(bench)
    bench.order("power_cut")
    bench.steps(40)
    data = bench.emulator.trace.data()
    begin = data.event_stamp[np.flatnonzero(data.event_kind == "power_cut")[-1]]
    after = data.stamp > begin + 0.15
    assert np.abs(data.joint_speeds[after]).max() < 1e-9
    with pytest.raises(ArmConnectionError):
        bench.query()
    count = len(bench.samples)
    bench.steps(20)
    assert len(bench.samples) == count
    bench.healthy()
    until(lambda: not bench.client.connection.connected)
    until(lambda: bench.client.connection.connected)
    with pytest.raises(RefusedError):
        bench.demand({"command": "movej", "v": 20, "joint": [0] * 6}, "receive_state")
    back(bench)


def test_a_stalled_controller_goes_to_the_last_target_and_reads_on_afterwards(bench):
    bench.order("stalled", duration=0.4)
    bench.client.stream_joints(READY + 0.01)
    bench.steps(20)
    assert_allclose(bench.emulator.truth().joints, READY, atol=1e-3)
    assert np.isnan(bench.emulator.trace.data().pushed_force[-10:]).all()
    until(lambda: np.abs(bench.emulator.truth().joints - READY - 0.01).max() < 1e-4)
    bench.query()
    back(bench)


def test_a_body_comes_near_along_the_axis_and_goes_away_again(bench):
    distance = AXIS @ (TARGET[:3, 3] - bench.emulator.truth().T_base_head[:3, 3])
    bench.emulator.order(Fault("body_push", value=0.5, duration=1.0))
    until(lambda: bench.emulator.truth().contact.compression > 0.0)
    data = bench.emulator.trace.data()
    begin = data.event_stamp[np.flatnonzero(data.event_kind == "body_push")[-1]]
    assert (data.stamp[-1] - begin) * 0.5 > distance - 0.03
    bench.healthy()
    until(lambda: bench.emulator.truth().contact.compression < -0.5 * distance)


def test_frames_of_the_stream_are_in_the_trace(bench):
    bench.client.stream_joints(READY)
    before = time.monotonic()
    until(lambda: len(bench.emulator.trace.data().frame_stamp))
    data = bench.emulator.trace.data()
    assert_allclose(data.frame_joints[-1], READY, atol=1e-5)
    assert abs(data.frame_stamp[-1] - before) < 5.0
