"""A control loop in virtual time, without thread or socket; the arm does, and feels, what it is told."""

import numpy as np
from arm_poses import ARM, HOME, JOINT_PACE, PERIOD, TARGET
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import State
from bathbot_scrub.arm.tool_path import retreated
from bathbot_scrub.rm65.guard.following_error import NO_LAG
from bathbot_scrub.rm65.guard.force_checks import Reading
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from bathbot_scrub.rm65.guard.signal_health import Connected, Signals
from bathbot_scrub.rm65.motion.arm_link import Sensed
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.rm65.motion.control_loop import ControlLoop
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner, line_pace
from bathbot_scrub.rm65.paths.surroundings import Surroundings
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.clock import Clock

LIMITS = shipped_force_limits()
TRUNK = LIMITS.region("Trunk_skin")
CALM = Signals(
    0.004, 0, 0, True, 0, np.zeros(6), (), (), NO_LAG, Connected(True, "", 0.0), None
)  # fmt: skip
OUTWARD = -TARGET[:3, 2]


class VirtualClock(Clock):
    """The time of a cell."""

    def __init__(self, cell):
        self._cell = cell

    def __call__(self):
        return self._cell.now


class Now:
    """A beat that is always due."""

    def passed(self):
        return True

    def bring_forward(self, due):
        pass


class Link:
    """Implements the part of `ArmLink` that the loop asks."""

    def __init__(self, joints):
        self.joints, self.wrench, self.signs = joints, np.zeros(6), {}
        self.told_joints, self.age = [], 0.004

    def sense(self, now):
        wrench = self.wrench
        return Sensed(Reading(now, wrench, wrench, wrench, (), self.age), self.joints)

    connected = True

    def signals(self, now, activity):
        return CALM._replace(activity=activity, age=self.age, **self.signs)

    def stream(self, joints):
        self.joints = joints

    def told(self, joints, now):
        if joints is not None:
            self.told_joints.append(joints)

    def stop_behind(self):
        pass


class LoopCell:
    """A loop, its link and its planner, and the time."""

    def __init__(self, joints=HOME, **settings):
        self.now, self.log = 100.0, []
        self.settings = DriverSettings(**settings)
        self.around = Surroundings(ARM, self.settings, lambda: self.now)
        self.planner = MotionPlanner(ARM, HOME, JOINT_PACE, 0.5, surroundings=self.around)
        self.link = Link(joints)
        self.loop = ControlLoop(
            self.link, self.planner, ForceGuard(LIMITS), self.settings, self.log.append, VirtualClock(self)
        )
        self.step(25)  # in which the loop sees that the arm stands at home, untouched

    @property
    def state(self):
        return self.loop.guard.state

    def step(self, count=1):
        for _ in range(count):
            self.now += PERIOD
            self.loop.thread.once(Now())

    def until(self, condition, most=2000):
        for _ in range(most):
            if condition():
                return
            self.step()
        raise AssertionError(f"not within {most} periods: {self.state.name}, {self.loop.guard.reason}")

    def head(self):
        """Pose of the head, (4, 4)."""
        return ARM.head(self.link.joints)

    def gap(self):
        """How far the head is off the target, along the outward normal [m]."""
        return float((self.head()[:3, 3] - TARGET[:3, 3]) @ OUTWARD)

    def speeds(self, since=0):
        """Of the head after each period that was commanded since the one given [m/s]."""
        heads = ARM.head(np.array(self.link.told_joints[since:]))[:, :3, 3]
        return np.linalg.norm(np.diff(heads, axis=0), axis=1) / PERIOD

    def press(self, force):
        """Let the head feel a force [N] against its z; 0: nothing."""
        self.link.wrench = np.array([0.0, 0.0, -force, 0.0, 0.0, 0.0])

    def on_the_way(self, speed=None):
        """Begin to go to the stand-off."""
        way = self.planner.to_pose(HOME, retreated(TARGET, 0.06))
        with self.loop.lock:
            self.loop.guard.begin_approach(TRUNK)
            self.loop.begin(way, JOINT_PACE, MotionKind.TRANSIT)
        return way

    def in_contact(self):
        """Go to the target, and feel the skin there."""
        self.on_the_way()
        self.until(lambda: not self.loop.moving)
        line = self.planner.line(self.link.joints, 0.072, 0.05)
        with self.loop.lock:
            self.loop.guard.begin_seeking()
            self.loop.begin(line, line_pace(0.05, 0.3), MotionKind.SEEK)
        self.until(lambda: self.gap() < -0.002)
        self.press(1.5)
        self.until(lambda: self.state is State.CONTACT and not self.loop.moving)

    def scrub(self, length=0.06, speed=0.05):
        """Begin to scrub along the skin."""
        ends = np.stack([self.head()] * 2)
        ends[1, :3, 3] += length * TARGET[:3, 1]
        path = self.planner.tool_path(self.link.joints, ends, speed)
        with self.loop.lock:
            self.loop.begin(path, line_pace(speed, 0.3), MotionKind.SCRUB)
        return path
