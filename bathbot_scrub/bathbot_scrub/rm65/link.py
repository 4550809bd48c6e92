"""The driver's link to one controller: connects, orders the state push, keeps the newest sample.

Runs in the background for as long as the driver lives; a wrong address or a lost cable is reported
once per reason and tried again.
"""

import math
import threading
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.client import ArmClient, Connection
from bathbot_scrub.rm65.errors import ArmConnectionError, ArmError, NotReadyError, RefusedError
from bathbot_scrub.rm65.force_excess import Reading
from bathbot_scrub.rm65.state_push import ArmSample, StateReceiver
from bathbot_scrub.rm65.wrench_filter import HeadWrench, WrenchFilter

Array = NDArray[np.float64]
_RETRY = 1.0  # [s] between attempts to order the push
_SETTLE = 0.15  # [s] for the filter after zeroing
_SILENCE = 2.0  # [s] without push after which it is ordered again


class Sensed(NamedTuple):
    """What was measured last."""

    reading: Reading
    joints: Array  # [rad], shape (6,); NaN before the first sample


class Link:
    """TCP client and UDP receiver of one controller, set up as the driver needs them."""

    def __init__(
        self, host: str, port: int, udp_port: int, variant: str, cutoff: float, warn: Callable[[str], None]
    ) -> None:
        """Listen to the push; `start` begins to connect.

        Args:
            host: Address of the controller.
            port: Its TCP port.
            udp_port: Ours for the push; 0: any free one.
            variant: That the controller must have.
            cutoff: Of the wrench filter [Hz].
            warn: Takes one line for the log, at every new reason.

        Raises:
            ArmConnectionError: When our UDP port is taken.
        """
        self._variant, self._warn = variant, warn
        self._lost: Callable[[], None] = lambda: None
        self._filter = WrenchFilter(cutoff)
        self._filter_lock = threading.Lock()
        self.wrench: HeadWrench | None = None
        self.sample: ArmSample | None = None
        self.trouble = "not yet connected"
        self._told: set[str] = set()  # since it last worked
        self._ready = False
        self._wake = threading.Event()
        self._open = True
        self.receiver = StateReceiver(udp_port, self._take)
        self.client = ArmClient(host, port, self._connection)
        self._thread = threading.Thread(target=self._keep, name="rm65-link", daemon=True)

    def start(self, lost: Callable[[], None]) -> None:
        """Begin to connect; `lost` is called whenever the connection is lost."""
        self._lost = lost
        self.client.start()
        self._thread.start()

    @property
    def connected(self) -> bool:
        """Whether the controller is set up and its TCP connection stands."""
        return self._ready and self.client.connection.connected

    def sense(self) -> Sensed:
        """What was measured last; NaN and an infinite age before the first sample."""
        wrench, sample, connected = self.wrench, self.sample, self.connected
        if wrench is None or sample is None:
            nothing = np.full(6, np.nan)
            return Sensed(Reading(nothing, math.nan, math.nan, math.inf, connected), nothing)
        age = time.monotonic() - wrench.stamp
        return Sensed(Reading(wrench.filtered, wrench.sudden, wrench.rise, age, connected), sample.joints)

    def zero_force(self, most: float) -> float:
        """Zero the sensor, at rest; give the resultant [N] that remains. Blocks for a fifth of a second.

        Raises:
            NotReadyError: When more than `most` [N] remains.
            RefusedError: When the controller refuses.
            ArmConnectionError: Without connection.
        """
        self.client.demand({"command": "clear_force_data"}, "clear_state")
        time.sleep(0.03)  # samples on their way are older than the reply
        with self._filter_lock:
            self._filter.reset()
        time.sleep(_SETTLE)
        residual = math.inf if self.wrench is None else self.wrench.force
        if not residual <= most:
            raise NotReadyError(
                f"{residual:.2f} N remain after zeroing, more than {most} N; is the arm at rest and free?"
            )
        return residual

    def close(self) -> None:
        """End everything."""
        self._open = False
        self._wake.set()
        self.client.close()
        self._thread.join(3.0)
        self.receiver.close()

    def _take(self, sample: ArmSample) -> None:
        with self._filter_lock:
            self.wrench = self._filter.update(sample.stamp, sample.wrench)
        self.sample = sample

    def _connection(self, connection: Connection) -> None:
        if not connection.connected:
            self._ready = False
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
            self._wake.wait(_RETRY)
            self._wake.clear()
            if not (self._open and self.client.connection.connected):
                continue
            silent = self._ready and self.receiver.age() > _SILENCE
            if silent:
                self._complain(
                    f"no state comes to UDP port {self.receiver.port}; check firewall and udp_port"
                )
            if silent or not self._ready:
                try:
                    self._set_up()
                except ArmConnectionError as error:
                    self._complain(str(error))
                    self.client.reconnect()
                except ArmError as error:
                    self._complain(str(error))
            elif self.trouble:
                self.trouble = ""
                self._told.clear()

    def _set_up(self) -> None:
        self.receiver.source = self.client.controller_address()
        info = self.client.request({"command": "get_arm_software_info"})
        product = str(info.get("Product_version", ""))
        if _variant_of(product) != self._variant:
            raise RefusedError(
                f"the controller says it is {product[:20]!r}, but parameter variant is "
                f"{self._variant}; set variant to {_variant_of(product) or 'B, 6F or 6FB'}"
            )
        self.client.demand(
            {
                "command": "set_realtime_push",
                "cycle": 1,
                "enable": True,
                "port": self.receiver.port,
                "force_coordinate": 0,
                "ip": self.client.local_address(),
            },
            "state",
        )
        self._ready = True


def _variant_of(product: str) -> str:
    """Variant in a product name such as RM65-6FI (I: third generation) or RM65-B-V; empty when unknown."""
    name = product.upper().removeprefix("RM65-").removeprefix("RM_65-").removesuffix("-V").removesuffix("I")
    return name if name in ("B", "6F", "6FB") else ""
