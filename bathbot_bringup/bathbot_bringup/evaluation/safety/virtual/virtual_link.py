"""The driver's link to an emulated controller that needs no network; frames and datagrams are the real ones.

Both ways have latency and jitter. Faults of the sessions act as they do over TCP: who is deaf obeys nothing,
who stands still obeys later.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from bathbot_scrub.arm.errors import ArmConnectionError, ProtocolError, RefusedError
from bathbot_scrub.rm65.controller.client import REPLY_TIMEOUT, stream_frame
from bathbot_scrub.rm65.controller.protocol import Frame
from bathbot_scrub.rm65.controller.state_push import ArmSample, clearing, parse_sample
from bathbot_scrub.rm65.force.wrench_filter import HeadWrench
from bathbot_scrub.rm65.force.zeroing import Zeroing
from bathbot_scrub.rm65.guard.signal_health import Activity, Connected, Signals
from bathbot_scrub.rm65.motion.arm_link import LinkCounts, Sensed
from bathbot_scrub.rm65.motion.arm_senses import ArmSenses
from bathbot_scrub.rm65.settings import DriverSettings
from numpy.typing import NDArray

from bathbot_bringup.evaluation.safety.virtual.virtual_clock import VirtualClock
from bathbot_bringup.evaluation.safety.virtual.wire import Wire
from bathbot_bringup.sim.arm.commands.table import Desk, reply
from bathbot_bringup.sim.faults.lasting_fault import Place
from bathbot_bringup.sim.faults.session_faults import SessionTrouble, session_trouble

Array = NDArray[np.float64]
_ASK = 0.03  # [s] between questions that show that the controller still listens
_AGAIN = 0.5  # [s] from a connection that was lost to the next


class Wires(NamedTuple):
    """What lies between driver and controller."""

    samples: Wire
    replies: Wire
    commands: Wire


class VirtualLink:
    """An `ArmLink`; one thread."""

    def __init__(self, settings: DriverSettings, desk: Desk, clock: VirtualClock, wires: Wires) -> None:
        """Connect a driver with `settings` to a controller's desk."""
        self.trouble, self._connected = "", True
        self._desk, self._clock, self._wires = desk, clock, wires
        self._senses = ArmSenses(settings)
        clear = {"command": "clear_force_data"}
        self.zeroing = Zeroing(
            lambda: self._demand(clear, "clear_state"), lambda: self.wrench, self._senses.begin_anew, clock
        )
        self._lost: Callable[[], None] = lambda: None
        self._news: Callable[[], None] = lambda: None
        self._held: list[Frame] = []  # by a controller that stands still
        self._asked: float | None = None  # [s]
        self._powered = True
        self._samples = self._refused = 0

    def start(self, lost: Callable[[], None], news: Callable[[], None]) -> None:
        """Begin to ask; `lost` is called when the connection is lost, `news` at every sample."""
        self._lost, self._news = lost, news
        self._ask()

    @property
    def sample(self) -> ArmSample | None:
        """Newest state of the arm; None before the first."""
        return self._senses.sample

    @property
    def wrench(self) -> HeadWrench | None:
        """Newest filtered force; None before the first."""
        return self._senses.wrench

    @property
    def connected(self) -> bool:
        """Whether the controller hears us."""
        return self._connected

    def push(self, data: bytes) -> None:
        """Take a datagram from the controller; it arrives in due time."""
        self._wires.samples.send(lambda: self._take(data))

    def _take(self, data: bytes) -> None:
        try:
            sample = parse_sample(data, self._clock())
        except ProtocolError:
            self._refused += 1
            self._senses.refuse()
            return
        self._samples += 1
        self._senses.take(sample)
        self._news()

    def sense(self, now: float) -> Sensed:
        """What was measured last, as it is at `now` [s]."""
        return self._senses.sense(now)

    def signals(self, now: float, activity: Activity) -> Signals:
        """What the watchdogs judge at `now` [s]."""
        waited = 0.0 if self._asked is None else now - self._asked
        tcp = Connected(self._connected, self.trouble, waited, self._powered)
        return self._senses.signals(now, tcp, activity)

    def stream(self, joints: Array) -> None:
        """Command joints [rad], shape (6,), one period after the last."""
        self._post(stream_frame(joints))

    def told(self, joints: Array | None, now: float) -> None:
        """Know what is commanded at `now` [s]; None: nothing."""
        self._senses.told(joints, now)

    def stop_behind(self) -> None:
        """Have the arm stopped behind all commands that still wait."""
        self._post({"command": "set_arm_stop"})

    def clear_errors(self) -> None:
        """Ask the controller to forget the errors it keeps."""
        for frame, key in clearing(self.sample):
            self._demand(frame, key)

    def counts(self) -> LinkCounts:
        """What has come so far."""
        return LinkCounts(self._samples, self._refused, 0)

    def close(self) -> None:
        """End everything."""
        self.drop()

    def drop(self) -> None:
        """Lose the connection; it comes back half a second later, unless something keeps it away."""
        if self._connected:
            self._connected, self._asked, self.trouble = False, None, "the connection was lost"
            self._lost()
            self._clock.at(self._clock() + _AGAIN, self._connect)

    def _connect(self) -> None:
        if self._sessions.cut_off:
            self._clock.at(self._clock() + _AGAIN, self._connect)
        else:
            self._connected, self.trouble = True, ""

    def take_held(self) -> None:
        """Obey what has waited in front of a controller that stood still."""
        held, self._held = self._held, []
        for frame in held:
            reply(self._desk, frame)

    @property
    def _sessions(self) -> SessionTrouble:
        return session_trouble(self._desk.controller.faults.at(Place.SESSIONS))

    def _post(self, frame: Frame) -> None:
        if not self._connected:
            raise ArmConnectionError(f"no connection for {frame['command']}: {self.trouble}")
        self._wires.commands.send(lambda: self._obey(frame))

    def _obey(self, frame: Frame, answered: Callable[[Any], None] = lambda answer: None) -> None:
        trouble = self._sessions
        if trouble.waiting:
            self._held.append(frame)
        elif not trouble.deaf:
            answer = reply(self._desk, frame)
            self._wires.replies.send(lambda: answered(answer), trouble.delay)

    def _demand(self, frame: Frame, key: str) -> None:
        """Send a command and let time pass until its reply has come."""
        answers: list[Frame] = []
        self._wires.commands.send(lambda: self._obey(frame, answers.append))
        if not self._clock.until(lambda: bool(answers), REPLY_TIMEOUT):
            raise ArmConnectionError(f"no reply to {frame['command']} within {REPLY_TIMEOUT} s")
        if answers[0].get(key) is not True:
            raise RefusedError(f"the controller refused {frame['command']}: {answers[0]}")

    def _ask(self) -> None:
        """Ask something cheap, again and again, to know that the controller still listens."""
        now = self._clock()
        self._clock.at(now + _ASK, self._ask)
        if self._asked is not None and now - self._asked > REPLY_TIMEOUT:
            self.drop()
        elif self._connected and self._asked is None:
            self._asked = now
            self._wires.commands.send(lambda: self._obey({"command": "get_arm_power_state"}, self._answered))

    def _answered(self, answer: Frame) -> None:
        self._asked, self._powered = None, answer.get("power_state", 1) in (1, True)
