"""The vendor driver's topics on our driver, over DDS: what programs written for it see."""

import time

import numpy as np
import pytest
from bathbot_depthcorr.ros.pose_decoding import transforms_from_poses
from bathbot_localize.messages import pose_from_transform
from bathbot_scrub.rm65.arm.rm65 import RM65
from emulator_cell import READY_DEG
from emulator_probe import Probe, walled_arm
from geometry_msgs.msg import Pose
from numpy.testing import assert_allclose
from rm_ros_interfaces.msg import Jointerrorcode, Jointpos, Movej, Movejp, Movel, Sixforce
from std_msgs.msg import Bool, UInt16

from bathbot_msgs.msg import ArmState

pytestmark = pytest.mark.graph

READY = np.radians(READY_DEG)
RESULTS = ("movej", "movej_p", "movel", "move_stop", "clear_force_data")
COMMANDS = {
    "movej": Movej,
    "movej_p": Movejp,
    "movel": Movel,
    "move_stop": Bool,
    "clear_force_data": Bool,
    "movej_canfd": Jointpos,
}
STATE = {
    "udp_arm_position": Pose,
    "udp_six_force": Sixforce,
    "udp_six_zero_force": Sixforce,
    "udp_joint_error_code": Jointerrorcode,
    "udp_arm_err": UInt16,
    "udp_sys_err": UInt16,
    "udp_arm_coordinate": UInt16,
}


class VendorProgram:
    """What a program written against the vendor's driver does."""

    def __init__(self, probe):
        self.probe, self.results = probe, {}
        self.publishers = {
            name: probe.node.create_publisher(kind, f"rm_driver/{name}_cmd", 10)
            for name, kind in COMMANDS.items()
        }
        for name in RESULTS:
            probe.node.create_subscription(
                Bool, f"rm_driver/{name}_result", lambda m, name=name: self.results.update({name: m.data}), 10
            )
        for name, kind in STATE.items():
            probe.node.create_subscription(
                kind, f"rm_driver/{name}", lambda m, name=name: probe.newest.update({name: m}), 10
            )

    def send(self, name, message):
        publisher = self.publishers[name]
        self.probe.until(lambda: publisher.get_subscription_count() > 0)
        publisher.publish(message)

    def ask(self, name, message):
        self.results.pop(name, None)
        self.send(name, message)
        self.probe.until(lambda: name in self.results)
        return self.results[name]

    def joints(self):
        return np.array(self.probe.newest["joint_states"].position)

    def settle(self):
        """Wait until what is measured is older than the last motion."""
        until = time.monotonic() + 0.2
        self.probe.until(lambda: time.monotonic() > until)

    def stand(self):
        """Wait until the arm has come to rest, however busy the machine is; give its joints [rad]."""
        rest = self.joints()
        last = time.monotonic()

        def at_rest():
            nonlocal rest, last
            if np.abs(self.joints() - rest).max() > 1e-5:
                rest, last = self.joints(), time.monotonic()
            return time.monotonic() > last + 0.2

        self.probe.until(at_rest)
        return self.joints()


@pytest.fixture(scope="module")
def program():
    probe = Probe()
    with walled_arm(probe, vendor_topics="true", joint_speed=2.0, joint_acceleration=6.0):
        program = VendorProgram(probe)
        probe.until(lambda: set(STATE) <= set(probe.newest))
        yield program
    probe.close()


def test_state_comes_under_the_vendors_names(program):
    newest = program.probe.newest
    flange = RM65("6F").flange(program.joints())
    assert_allclose(transforms_from_poses([newest["udp_arm_position"]])[0], flange, atol=1e-4)
    raw, zero = newest["udp_six_force"], newest["udp_six_zero_force"]
    assert abs(raw.force_fz) > 1.0  # the brush's weight and the bias
    assert abs(zero.force_fz) < 1.0
    assert list(newest["udp_joint_error_code"].joint_error) == [0] * 6
    assert (newest["udp_arm_err"].data, newest["udp_sys_err"].data) == (0, 0)


def test_moves_end_where_they_are_sent_and_tell_so(program):
    goal = READY + np.array([0.1, 0.05, 0.05, 0.0, -0.05, 0.2])
    assert program.ask("movej", Movej(joint=goal.tolist(), speed=50, dof=6))
    program.settle()
    assert_allclose(program.joints(), goal, atol=1e-3)
    back = RM65("6F").flange(READY)
    assert program.ask("movej_p", Movejp(pose=pose_from_transform(back), speed=50))
    program.settle()
    assert_allclose(program.joints(), READY, atol=1e-3)
    away = back.copy()
    away[:3, 3] -= 0.03 * back[:3, 2]
    assert program.ask("movel", Movel(pose=pose_from_transform(away), speed=100))
    program.settle()
    assert_allclose(RM65("6F").flange(program.joints()), away, atol=1e-3)
    assert program.probe.state()[0] == ArmState.FREE


def test_a_stream_is_followed_to_its_last_frame_and_stop_ends_it(program):
    start = program.joints()
    steps = [start + 0.15 * np.sin(s) * np.array([1, 0, 0, 0, 0, 1]) for s in np.linspace(0, np.pi / 2, 40)]
    for frame in steps:
        program.send("movej_canfd", Jointpos(joint=frame.tolist(), follow=True, dof=6))
        program.probe.executor.spin_once(timeout_sec=0.02)
    program.probe.until(lambda: np.abs(program.joints() - steps[-1]).max() < 1e-3)
    program.probe.until(lambda: program.probe.state()[0] == ArmState.FREE)
    back = steps[::-1]
    for frame in back[:10]:
        program.send("movej_canfd", Jointpos(joint=frame.tolist(), follow=True, dof=6))
        program.probe.executor.spin_once(timeout_sec=0.02)
    assert program.ask("move_stop", Bool(data=True))
    for frame in back[10:14]:  # what was on its way does not move the arm again
        program.send("movej_canfd", Jointpos(joint=frame.tolist(), follow=True, dof=6))
        program.probe.executor.spin_once(timeout_sec=0.02)
    stood = program.stand()
    program.settle()
    assert_allclose(program.joints(), stood, atol=1e-4)
    assert stood[0] > back[9][0] - 1e-3  # nor does it pass what came before the stop
    assert np.abs(stood - back[13]).max() > 1e-3
    assert program.probe.state()[0] == ArmState.HOLD


def test_frames_behind_a_stop_begin_no_new_stream_though_the_old_one_was_over(program):
    start = program.stand()
    program.settle()  # more than the silence that ends a stream
    assert program.ask("move_stop", Bool(data=True))
    steps = [start + 0.1 * s * np.array([1, 0, 0, 0, 0, 1]) for s in np.linspace(0, 1, 40)]
    for frame in steps:
        program.send("movej_canfd", Jointpos(joint=frame.tolist(), follow=True, dof=6))
        program.probe.executor.spin_once(timeout_sec=0.02)
    assert_allclose(program.stand(), start, atol=1e-4)
    assert program.probe.state()[0] == ArmState.HOLD
    program.settle()
    for frame in steps:  # silence was kept meanwhile, whenever the last of them arrived
        program.send("movej_canfd", Jointpos(joint=frame.tolist(), follow=True, dof=6))
        program.probe.executor.spin_once(timeout_sec=0.02)
    program.probe.until(lambda: np.abs(program.joints() - steps[-1]).max() < 1e-3)


def test_what_cannot_be_done_is_answered_with_false(program):
    assert not program.ask("movej", Movej(joint=[0.0] * 5, speed=50))
    assert not program.ask("movej", Movej(joint=[4.0, 0.0, 0.0, 0.0, 0.0, 0.0], speed=50))
    assert not program.ask("movej", Movej(joint=READY.tolist(), speed=0))
    assert not program.ask("movej_p", Movejp(pose=Pose(), speed=50, trajectory_connect=1))
    far = RM65("6F").flange(READY)
    far[0, 3] += 2.0
    assert not program.ask("movel", Movel(pose=pose_from_transform(far), speed=50))
    assert program.ask("clear_force_data", Bool(data=True))
