"""A cell in virtual time: the real driver, the emulated controller with its true contact, and a person.

How a trial is written:

    cell = VirtualCell("Face_skin", seed=3, approach_speed=0.02)    # further keywords: driver settings
    cell.approach()                                                 # blocks, in virtual time only
    cell.scrub()                                                    # to and fro, fed as the planner does
    cell.wait(1.0)
    cell.lean(0.06, 0.1)                                            # from now on: 60 mm at 100 mm/s
    cell.wait(2.0)
    assert cell.peak() < cell.region.hard_stop                      # the true force [N], all along
    assert cell.state() is State.HOLD

All of the driver runs as it does beside an arm: `cell.driver` has `approach`, `follow`, `retract`, `stop`,
`pause`, `resume`, `home`, `zero_force`, and `cell.driver.loop` its guard and motion. What blocks there lets
virtual time pass: no thread, no network, no sleep. To have something happen while the driver is on its way,
order it before: `cell.after(0.4, cell.driver.stop)`, `cell.lean(0.12, 0.2, after=0.4)`,
`cell.when(lambda: cell.gap() < 0.1, lambda: cell.lean(0.12, 0.2))`; or wait for it:
`cell.clock.until(lambda: not cell.moving(), 20.0)`. `cell.order(Fault("lost_udp"))` lets
anything fail that the emulator knows. `cell.look(0.2, 0.2)` shows the driver a body cloud five times a
second, 0.2 s late; without it none ever comes. Errors of the driver's thread end in FAULT, with their text in
`cell.log`. The seed draws noise of the sensor, jitter of the wires and where in its cycle each side begins.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.arm.force_limits import load_force_limits
from bathbot_scrub.arm.states import State
from bathbot_scrub.arm.tool_path import retreated
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.driver import ArmDriver
from bathbot_scrub.rm65.motion.approach import Request, Touch
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.beat import Beat
from numpy.typing import NDArray

from bathbot_bringup.evaluation.safety.trial.stroke_player import Progress, StrokePlayer
from bathbot_bringup.evaluation.safety.virtual.person import Lean, Person, Sway
from bathbot_bringup.evaluation.safety.virtual.virtual_clock import VirtualClock
from bathbot_bringup.evaluation.safety.virtual.virtual_link import VirtualLink, Wires
from bathbot_bringup.evaluation.safety.virtual.wire import Delay, Wire
from bathbot_bringup.sim.arm.commands.table import Desk
from bathbot_bringup.sim.arm.controller.arm_setup import Arm
from bathbot_bringup.sim.arm.controller.controller import STEP, Controller
from bathbot_bringup.sim.arm.controller.push import datagram
from bathbot_bringup.sim.arm.emulator.emulator import trace_row
from bathbot_bringup.sim.arm.trace import Trace
from bathbot_bringup.sim.brush import Brush
from bathbot_bringup.sim.faults.fault_schedule import BEGIN, FaultEvent
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_bringup.sim.faults.kinds import KINDS
from bathbot_bringup.sim.faults.lasting_fault import Place
from bathbot_bringup.sim.faults.push_faults import Outbox

Array = NDArray[np.float64]
VARIANT = "6F"
AXIS = np.array([1.0, -0.5, -0.1]) / np.linalg.norm([1.0, -0.5, -0.1])  # into the skin
_SIDE = np.cross([0.0, 0.0, 1.0], AXIS) / np.linalg.norm(np.cross([0.0, 0.0, 1.0], AXIS))
TARGET = np.eye(4)  # head pose on the skin
TARGET[:3, :3] = np.stack([np.cross(_SIDE, AXIS), _SIDE, AXIS], axis=-1)
TARGET[:3, 3] = 0.54, -0.05, 0.2
TARGET.setflags(write=False)
_FEED = 0.02  # [s] between looks at whether the arm needs another segment
_STROKE, _POSE = 0.04, 0.002  # [m] of a stroke to either side; between its poses
_LOOKED = 0.05  # [s] until the driver has looked at a new cloud, as its thread does
_SOONEST = 1e-5  # [s] to the next beat: what is left of a period may be a rounding error


@cache
def _kinematics() -> RM65:
    return RM65(VARIANT)


@cache
def ready_deg(distance: float) -> tuple[float, ...]:
    """Joints [deg] that hold the head `distance` [m] before the target: a home that saves time."""
    solutions = _kinematics().solve_head(retreated(TARGET, distance))
    return tuple(np.degrees(nearest(solutions, np.radians([0, -40, -100, 0, 60, 0]), RM65_LIMITS)).tolist())


class VirtualCell:
    """Driver, controller and person; what the driver said stands in `log`, what happened in `trace`."""

    def __init__(
        self,
        region: str = "Trunk_skin",
        seed: int = 0,
        sways: tuple[Sway, ...] = (),
        delay: Delay = Delay(),
        **settings: Any,
    ) -> None:
        """Put a person with skin of `region` before an arm that stands at home, and connect.

        Args:
            region: Class of the skin, for its stiffness and its limits.
            seed: Of everything that is chance.
            sways: How the person moves all the time.
            delay: Of the wires, one way.
            settings: Of the driver, where they are not the shipped ones.
        """
        self.rng, self.clock, self.log = np.random.default_rng([seed, 65]), VirtualClock(), list[str]()
        self.settings, self.limits = DriverSettings(**settings), load_force_limits()
        self.region_name, self.region = region, self.limits.region(region)
        self.person, self.trace, self._outbox = Person(TARGET, region, sways), Trace(), Outbox()
        self.controller = Controller(
            Arm(_kinematics(), RM65_LIMITS, Brush()),
            np.radians(self.settings.home_deg),
            self.person,
            self.clock,
            self.rng,
        )
        self._desk = Desk(self.controller, trace=self.trace, clock=self.clock)
        wires = Wires(*(Wire(self.clock, self.rng, delay) for _ in range(3)))
        self.link = VirtualLink(self.settings, self._desk, self.clock, wires)
        self.driver = ArmDriver(
            self.settings, self.limits, _kinematics(), self.link, self.log.append, self.clock
        )
        self._beat = Beat(1.0 / self.settings.rate, self.clock)
        self._beats, self._held_up_until = 0, 0.0
        self._path_id = 0
        begin = self.clock()
        self.clock.at(begin + STEP * float(self.rng.uniform()), self._step)
        self.clock.at(begin + float(self.rng.uniform()) / self.settings.rate, self._start)
        self.clock.until(lambda: self.driver.snapshot().connected, 1.0)

    def wait(self, seconds: float) -> None:
        """Let time pass [s]."""
        self.clock.sleep(seconds)

    def after(self, seconds: float, action: Callable[[], None]) -> None:
        """Have something happen, `seconds` from now; a refusal of the driver is logged."""
        self.clock.at(self.clock() + seconds, lambda: self._try(action))

    def when(self, condition: Callable[[], bool], action: Callable[[], None]) -> None:
        """Have something happen as soon as something holds; looked at after every step of the controller."""
        if condition():
            self._try(action)
        else:
            self.after(STEP, lambda: self.when(condition, action))

    def lean(self, distance: float, speed: float, after: float = 0.0) -> None:
        """Have the person lean by `distance` [m] at `speed` [m/s], `after` [s] from now."""
        self.person.lean(Lean(self.clock() + after, distance, speed))

    def order(self, fault: Fault) -> None:
        """Let something fail."""
        self.controller.faults.order(fault, self.clock())

    def hold_up(self, seconds: float) -> None:
        """Let the driver's control loop stand still for `seconds` [s], as that of a stopped process does."""
        self._held_up_until = self.clock() + seconds

    def look(self, every: float, late: float) -> None:
        """Show the driver where the body is, `every` so many seconds, `late` by so many."""
        points, stamp = self.person.cloud(self.clock()), self.clock()
        self.after(late, lambda: self.driver.surroundings.see(points, stamp))
        self.after(late + _LOOKED, self.driver.watch.look)
        self.after(every, lambda: self.look(every, late))

    def approach(self, **changes: Any) -> Touch:
        """Go to the target until skin is felt; `changes` to the request."""
        return self.driver.approach(
            Request(**{"T_base_target": TARGET, "region": self.region_name} | changes)
        )

    def scrub(self, depth: float = 0.005, speed: float = 0.05) -> None:
        """Begin a stroke to and fro without end, `depth` [m] in the skin at rest; as `follow`."""
        out = np.arange(0.0, _STROKE, _POSE)
        along = np.concatenate([out, _STROKE - out, -out, out - _STROKE])
        self.follow(self.poses(along, depth), speed)

    def sinking(self, depth: float) -> Array:
        """Poses to one side and back that sink from the skin to `depth` [m], for `follow`."""
        out = np.arange(0.0, _STROKE, _POSE)
        along = np.concatenate([out, _STROKE - out])
        return self.poses(along, np.linspace(0.0, depth, len(along)))

    def poses(self, along: Array, depth: Array | float) -> Array:
        """Head poses `along` y of the target [m], shape (N,), `depth` [m] in the skin at rest, (N, 4, 4)."""
        poses = np.tile(TARGET, (len(along), 1, 1))
        poses[:, :3, 3] += along[:, None] * _SIDE + np.reshape(depth, (-1, 1)) * AXIS
        return poses

    def follow(self, poses: Array, speed: float, region: str = "", pieces: int = 0) -> None:
        """Follow poses, (N, 4, 4), fed as the planner does until the driver takes no more.

        Args:
            poses: Of the head, N a multiple of the segment's length.
            speed: Wanted [m/s].
            region: That the segments name; the skin's own if left out.
            pieces: Segments after which the path ends; 0: it begins again and again.

        Raises:
            ArmError: When the first segment is refused.
        """
        self._path_id += 1
        player = StrokePlayer(self._path_id, region or self.region_name, poses, speed, pieces)
        self.driver.follow(player.take())
        self.after(_FEED, lambda: self._feed(player))

    def _feed(self, player: StrokePlayer) -> None:
        """Send what is due, until the arm takes no more of it."""
        now = self.driver.snapshot()
        segment = player.due(Progress(now.path_id, now.segment_index, now.path_done))
        if segment is not None:
            self.driver.follow(segment)
        self.after(_FEED, lambda: self._feed(player))

    def state(self) -> State:
        """State of the driver."""
        return self.driver.snapshot().state

    def moving(self) -> bool:
        """Whether any joint truly moves, as a person would see it."""
        return max(abs(speed) for speed in self.controller.dynamics.speeds) > 0.01

    def force(self) -> float:
        """True contact force [N]."""
        return float(np.linalg.norm(self.controller.contact.force))

    def gap(self) -> float:
        """Distance of the true head from the skin along the normal [m]; negative when pressed."""
        offset = self.controller.T_base_head[:3, 3] - TARGET[:3, 3]
        return float(offset @ self.person.outward) - self.person.shift(self.clock())

    def peak(self, since: float = 0.0) -> float:
        """Largest true contact force [N] from `since` [s] on."""
        data = self.trace.data()
        return float(np.linalg.norm(data.force[data.stamp >= since], axis=1).max(initial=0.0))

    def _try(self, action: Callable[[], None]) -> None:
        try:
            action()
        except ArmError as error:
            self.log.append(str(error))

    def _start(self) -> None:
        self._beat = Beat(1.0 / self.settings.rate, self.clock)
        self.link.start(self.driver.loop.connection_lost, self._serve)
        self._serve()

    def _serve(self) -> None:
        """Work as the control loop's thread does: now, and again when its beat is due."""
        held_up = self._held_up_until - self.clock()
        if held_up <= 0.0:
            self.driver.loop.thread.once(self._beat)
        self._beats += 1
        mine = self._beats
        due = self.clock() + max(self._beat.left(), held_up, _SOONEST)
        self.clock.at(due, lambda: self._serve() if self._beats == mine else None)

    def _step(self) -> None:
        """Advance controller and body by 5 ms, as the emulator does."""
        now, controller = self.clock(), self.controller
        self.clock.at(now + STEP, self._step)
        events = controller.faults.update(now)
        self.trace.events(events)
        for event in events:
            self._begin_or_end(event)
        controller.step()
        leaving = []
        if not controller.frozen:
            state = datagram(controller, self._desk.push)
            leaving = self._outbox.leaving(state, now, controller.faults.at(Place.PUSH))
        for one in leaving:
            self.link.push(one.data)
        self.trace.step(trace_row(now, controller, leaving[-1].force if leaving else np.nan))

    def _begin_or_end(self, event: FaultEvent) -> None:
        kind = KINDS[event.kind]
        (kind.at_begin if event.phase == BEGIN else kind.at_end)(self)

    def cut_power(self) -> None:
        """Let the joints lose power."""
        self.controller.cut_power()

    def freeze(self) -> None:
        """Let the controller's program stand still; the joints go on to the last target."""
        self.controller.frozen = True

    def thaw(self) -> None:
        """Let it go on, with what came in meanwhile."""
        self.link.take_held()
        self.controller.frozen = False

    def drop_clients(self) -> None:
        """Cut off the driver."""
        self.link.drop()

    def put_body_back(self) -> None:
        """Put the body where it was."""
        self.controller.skin.surface.put_back()
