"""The driver's link to one controller: connects, orders the state push, keeps the newest sample.

Runs in the background for as long as the driver lives; a wrong address or a lost cable is reported
once per reason and tried again.
"""

import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import ArmConnectionError, ArmError, RefusedError
from bathbot_scrub.rm65.controller.client import ArmClient, Connection
from bathbot_scrub.rm65.controller.state_push import ArmSample, StateReceiver, clearing
from bathbot_scrub.rm65.force.wrench_filter import HeadWrench
from bathbot_scrub.rm65.force.zeroing import Zeroing
from bathbot_scrub.rm65.guard.signal_health import Activity, Connected, Signals
from bathbot_scrub.rm65.motion.arm_link import LinkCounts, Sensed
from bathbot_scrub.rm65.motion.arm_senses import ArmSenses
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.clock import MONOTONIC, Clock

Array = NDArray[np.float64]
_RETRY = 1.0  # [s] between attempts to order the push
_SILENCE = 2.0  # [s] without push after which it is ordered again
_ASK = 0.03  # [s] between questions that show that the controller still listens


class ControllerLink:
    """The `ArmLink` of an RM65: TCP client and UDP receiver, set up as the driver needs them."""

    def __init__(
        self, settings: DriverSettings, warn: Callable[[str], None], clock: Clock = MONOTONIC
    ) -> None:
        """Listen to the push; `start` begins to connect.

        Args:
            settings: Addresses, variant, filter and tool.
            warn: Takes one line for the log, at every new reason.
            clock: Stamps samples and questions.

        Raises:
            ArmConnectionError: When our UDP port is taken.
        """
        self._variant, self._warn, self._clock = settings.variant, warn, clock
        self._lost: Callable[[], None] = lambda: None
        self._news: Callable[[], None] = lambda: None
        self._senses = ArmSenses(settings)
        self.trouble = "not yet connected"
        self._told: set[str] = set()  # since it last worked
        self._ready, self._powered = False, True
        self._set_up_at = 0.0  # [s]
        self._told_bad = False
        self._asked: float | None = None  # [s] when a question went out that has no answer yet
        self._wake = threading.Event()
        self._open = True
        self.receiver = StateReceiver(
            settings.udp_port, self._take, self._senses.refuse, self._exceed, clock=clock
        )
        self.client = ArmClient(settings.host, settings.port, self._connection)
        clear = {"command": "clear_force_data"}
        self.zeroing = Zeroing(
            lambda: self.client.demand(clear, "clear_state"),
            lambda: self.wrench,
            self._senses.begin_anew,
            clock,
        )
        self._thread = threading.Thread(target=self._keep, name="rm65-link", daemon=True)

    def start(self, lost: Callable[[], None], news: Callable[[], None]) -> None:
        """Begin to connect; `lost` is called when the connection is lost, `news` at every sample."""
        self._lost, self._news = lost, news
        self.client.start()
        self._thread.start()

    @property
    def connected(self) -> bool:
        """Whether the controller is set up and its TCP connection stands."""
        return self._ready and self.client.connection.connected

    @property
    def sample(self) -> ArmSample | None:
        """Newest state of the arm; None before the first."""
        return self._senses.sample

    @property
    def wrench(self) -> HeadWrench | None:
        """Newest filtered force; None before the first."""
        return self._senses.wrench

    def sense(self, now: float) -> Sensed:
        """What was measured last, as it is at `now` [s]; NaN and an infinite age before the first sample."""
        return self._senses.sense(now)

    def signals(self, now: float, activity: Activity) -> Signals:
        """What the watchdogs judge, at `now` [s]."""
        asked = self._asked
        waited = max(now - asked, 0.0) if asked is not None else 0.0
        reason = self.trouble or self.client.connection.reason
        tcp = Connected(self.connected, reason, waited, self._powered)
        return self._senses.signals(now, tcp, activity)

    def stream(self, joints: Array) -> None:
        """Command joints [rad], shape (6,), one period after the last."""
        self.client.stream_joints(joints)

    def told(self, joints: Array | None, now: float) -> None:
        """Know what is commanded at `now` [s]; None: nothing."""
        self._senses.told(joints, now)

    def stop_behind(self) -> None:
        """Have the arm stopped behind all commands that still wait."""
        self.client.post({"command": "set_arm_stop"})

    def counts(self) -> LinkCounts:
        """What has come over UDP and TCP so far."""
        return LinkCounts(self.receiver.accepted, self.receiver.rejected, self.client.protocol_errors)

    def clear_errors(self) -> None:
        """Ask the controller to forget the errors it keeps.

        Raises:
            ArmError: When it refuses or does not answer.
        """
        for frame, key in clearing(self.sample):
            self.client.demand(frame, key)

    def close(self) -> None:
        """End everything."""
        self._open = False
        self._wake.set()
        self.client.close()
        self._thread.join(3.0)
        self.receiver.close()

    def _take(self, sample: ArmSample) -> None:
        self._senses.take(sample)
        self._news()

    def _exceed(self) -> None:
        self._senses.exceed(self._clock())
        self._news()

    def _connection(self, connection: Connection) -> None:
        if not connection.connected:
            self._ready, self._asked = False, None
            self._complain(connection.reason)
            self._lost()
        self._wake.set()

    def _complain(self, trouble: str) -> None:
        if trouble not in self._told:
            self._warn(trouble)
            self._told.add(trouble)
        self.trouble = trouble

    def _keep(self) -> None:
        """Set the controller up at every connection, and again when its push stays away."""
        while self._open:
            self._wake.wait(_ASK if self.connected else _RETRY)
            self._wake.clear()
            if not (self._open and self.client.connection.connected):
                continue
            silent = self._ready and min(self.receiver.age(), self._clock() - self._set_up_at) > _SILENCE
            if silent:
                nothing = f"no state comes to UDP port {self.receiver.port}; check firewall and udp_port"
                self._complain(self.receiver.source.trouble or nothing)
            try:
                if silent or not self._ready:
                    self._set_up()
                else:
                    self._ask()
            except ArmConnectionError as error:
                self._complain(str(error))
                self.client.reconnect()
            except ArmError as error:
                self._complain(str(error))

    def _ask(self) -> None:
        """Ask something cheap, to know that the controller still listens."""
        self._asked = self._clock()
        answer = self.client.request({"command": "get_arm_power_state"})
        self._asked, self._powered = None, answer.get("power_state", 1) in (1, True)
        bad = self.client.last_error or self.receiver.last_error
        if bad and not self._told_bad:
            self._told_bad = True  # the rest is only counted
            self._warn(f"what the controller sent was refused: {bad}")
        if self.trouble and self.receiver.age() < _SILENCE:
            self.trouble = ""
            self._told.clear()

    def _set_up(self) -> None:
        info = self.client.request({"command": "get_arm_software_info"})
        product = str(info.get("Product_version", ""))
        if _variant_of(product) != self._variant:
            raise RefusedError(
                f"the controller says it is {product[:20]!r}, but parameter variant is "
                f"{self._variant}; set variant to {_variant_of(product) or 'B, 6F or 6FB'}"
            )
        local = self.client.local_address()
        self.receiver.listen_at(local)
        self.client.demand(
            {
                "command": "set_realtime_push",
                "cycle": 1,
                "enable": True,
                "port": self.receiver.port,
                "force_coordinate": 0,
                "ip": local,
            },
            "state",
        )
        self.receiver.expect(self.client.controller_address())
        self._ready, self._set_up_at = True, self._clock()


def _variant_of(product: str) -> str:
    """Variant in a product name such as RM65-6FI (I: third generation) or RM65-B-V; empty when unknown."""
    name = product.upper().removeprefix("RM65-").removeprefix("RM_65-").removesuffix("-V").removesuffix("I")
    return name if name in ("B", "6F", "6FB") else ""
