"""A lifecycle node that owns its endpoints: what a transition made ends with the one that undoes it."""

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.client import Client
from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from std_srvs.srv import Trigger

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.lifetime import Lifetime, Rank
from bathbot_depthcorr.node.long_work_node import Call, LongAction, at_once, beside
from bathbot_depthcorr.node.newest_worker import NewestWorker

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Closable(Protocol):
    """Something that ends in order."""

    def close(self) -> object:
        """End it."""


Held = TypeVar("Held", bound=Closable)


def guarded(callback: Callable[[Any], None], fail: Callable[[Exception], None]) -> Callable[[Any], None]:
    """A callback whose refusal of a message is handed to `fail`."""

    def call(message: Any) -> None:
        try:
            callback(message)
        except BathbotError as error:
            fail(error)

    return call


class EndpointOwner(LifecycleNode):
    """Makes endpoints and threads that live until `lifetime` is closed."""

    lifetime: Lifetime
    """Of the phase the node is in; what is made now belongs to it."""

    def __init__(self, name: str, **options: Any) -> None:
        """Make the node; `options` are those of rclpy's `Node`."""
        super().__init__(name, **options)
        # An answer that waits would hold the node's own group, and with it every other callback.
        self._slow_services = MutuallyExclusiveCallbackGroup()

    def listen(
        self,
        message_type: type,
        topic: str,
        callback: Callable[[Any], None],
        qos: QoSProfile | int,
        raw: bool = False,
        group: CallbackGroup | None = None,
    ) -> Subscription:
        """Subscribe; `raw` hands over bytes."""
        made = self.create_subscription(message_type, topic, callback, qos, raw=raw, callback_group=group)
        self.lifetime.keep(Rank.SOURCE, lambda: self.destroy_subscription(made))
        return made

    def every(self, period: float, callback: Callable[[], None]) -> Timer:
        """Call every `period` [s]."""
        made = self.create_timer(period, callback)
        self.lifetime.keep(Rank.SOURCE, lambda: self.destroy_timer(made))
        return made

    def publisher(self, message_type: type, topic: str, qos: QoSProfile | int) -> Publisher:
        """Offer a topic."""
        made = self.create_publisher(message_type, topic, qos)
        self.lifetime.keep(Rank.OUTLET, lambda: self.destroy_publisher(made))
        return made

    def client(self, service_type: type, name: str) -> Client:
        """Prepare to call a service."""
        made = self.create_client(service_type, name)
        self.lifetime.keep(Rank.OUTLET, lambda: self.destroy_client(made))
        return made

    def serve(
        self,
        service_type: type,
        name: str,
        callback: Callable[[Any, Any], Any],
        group: CallbackGroup | None = None,
    ) -> Service:
        """Offer a service."""
        made = self.create_service(service_type, name, callback, callback_group=group)
        self.lifetime.keep(Rank.OUTLET, lambda: self.destroy_service(made))
        return made

    def offer(self, name: str, call: Call) -> Service:
        """Offer a call that takes no time as a `Trigger` service."""
        return self.serve(Trigger, name, at_once(self, call))

    def offer_beside(self, name: str, call: Call) -> Service:
        """Offer a call that takes long as a `Trigger` service; such calls wait for each other only."""
        return self.serve(Trigger, name, beside(self, call), self._slow_services)

    def act(self, action_type: type, name: str, **callbacks: Callable[..., Any]) -> LongAction:
        """Offer an action whose goals take long; `callbacks` as of `LongAction`."""
        made = LongAction(self, action_type, name, **callbacks)
        self.lifetime.keep(Rank.OUTLET, made.close)
        return made

    def worker(
        self, work: Callable[[Any], None], fail: Callable[[Exception], None], **patience: float
    ) -> NewestWorker:
        """Start a thread that works on the newest items; `patience` as of `NewestWorker`."""
        return self.hold(NewestWorker(work, fail, **patience))

    def hold(self, part: Held) -> Held:
        """Close `part`, whatever works beside the executor, when this phase ends; gives it back."""
        self.at_end(part.close)
        return part

    def at_end(self, close: Callable[[], object]) -> None:
        """Call `close` when this phase ends, among the threads and devices, the newest first."""
        self.lifetime.keep(Rank.WORKER, close)
