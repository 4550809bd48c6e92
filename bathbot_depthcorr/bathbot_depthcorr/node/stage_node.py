"""The frame of every node: lifecycle with autostart, parameters from one dataclass, diagnostics.

A stage overrides `setup`, `start`, `stop` and, where it holds something, `teardown`. A
`BathbotError` raised in any of them becomes one log line, a diagnostic and a failed transition.
"""

import gc
import os
import signal
import sys
import threading
from dataclasses import MISSING, fields
from typing import Any

from bathbot_depthcorr.node import transport

os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
os.environ.setdefault(transport.RANGE, transport.LOCAL)
os.environ.setdefault(transport.PROFILES, transport.PICTURES)
# Synchronous publishing waits for slow readers with the interpreter's lock held: a busy recorder would
# stall the control loop of the arm.
os.environ.setdefault("RMW_FASTRTPS_PUBLICATION_MODE", "ASYNCHRONOUS")

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions

from bathbot_depthcorr.errors import BathbotError, SettingsError

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
_ALWAYS_ALLOWED = ("autostart", "use_sim_time", "start_type_description_service")


def _convert(name: str, value: Any, default: Any) -> Any:
    """Give `value` the type of `default`; refuse what would lose its meaning."""
    if isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if isinstance(default, tuple) and not isinstance(value, str) and hasattr(value, "__iter__"):
        kind = float if default and isinstance(default[0], float) else lambda item: item
        return tuple(kind(item) for item in value)
    if type(value) is not type(default):
        raise SettingsError(
            f"parameter {name} must be a {type(default).__name__}, got {value!r}; see the comments in config/"
        )
    return value


class StageNode(LifecycleNode):
    """A lifecycle node whose parameters are the fields of one settings dataclass."""

    def __init__(self, name: str, settings_type: type) -> None:
        """Declare a parameter for each field of `settings_type`, a dataclass with defaults."""
        super().__init__(name)
        self._settings_type, self._is_set_up = settings_type, False
        self.declare_parameter("autostart", True)
        for field in fields(settings_type):
            default = field.default if field.default is not MISSING else field.default_factory()
            stored = list(default) if isinstance(default, tuple) else default
            about = ParameterDescriptor(description=field.metadata.get("help", ""), dynamic_typing=True)
            self.declare_parameter(field.name, stored, about)
        self._status = DiagnosticStatus(name=name, hardware_id=name, level=WARN, message="not configured")
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_timer(1.0, self._publish_status)

    def setup(self, settings: Any) -> None:
        """Load what the stage needs; runs on configure."""

    def start(self) -> None:
        """Create subscriptions and threads; runs on activate."""

    def stop(self) -> None:
        """Undo `start`; runs on deactivate and at the end."""

    def teardown(self) -> None:
        """Undo `setup`; runs on cleanup and at the end, if `setup` came to its end."""

    def read_settings(self) -> Any:
        """Build the settings from the parameters.

        Raises:
            SettingsError: On an unknown name, a wrong type or a value outside its meaning.
        """
        known = {field.name: field for field in fields(self._settings_type)}
        for name in self._parameter_overrides:
            if name not in known and name not in _ALWAYS_ALLOWED and not name.startswith("qos_overrides"):
                raise SettingsError(f"unknown parameter {name}; known are {', '.join(known)}")
        values = {}
        for name, field in known.items():
            default = field.default if field.default is not MISSING else field.default_factory()
            values[name] = _convert(name, self.get_parameter(name).value, default)
        return self._settings_type(**values)

    def report(self, level: bytes, message: str, **values: Any) -> None:
        """Set this node's diagnostic; it is sent every second, and at once when the message changes."""
        changed = (level, message) != (self._status.level, self._status.message)
        self._status.level, self._status.message = level, message
        self._status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        if changed:
            self._publish_status()

    def autostart(self) -> bool:
        """Configure and activate unless a manager shall do so; tell whether that worked."""
        if not self.get_parameter("autostart").value:
            return True
        success = TransitionCallbackReturn.SUCCESS
        return self.trigger_configure() == success and self.trigger_activate() == success

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters and set up."""
        result = self._attempt("configured", lambda: self.setup(self.read_settings()))
        self._is_set_up = result == TransitionCallbackReturn.SUCCESS
        return result

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to work."""
        if self._attempt("active", self.start) != TransitionCallbackReturn.SUCCESS:
            return TransitionCallbackReturn.FAILURE
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop working."""
        self._attempt("inactive", self.stop)
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of what `setup` loaded."""
        return self._attempt("not configured", self._tear_down)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop from any state."""
        if state.label == "active":
            self._attempt("inactive", self.stop)
        return self._attempt("shut down", self._tear_down)

    def end(self) -> None:
        """Leave in order, from whatever state the node is in."""
        if self._state_machine.current_state[1] in ("unconfigured", "inactive", "active"):
            self.trigger_shutdown()
        self.destroy_node()

    def _tear_down(self) -> None:
        if self._is_set_up:
            self._is_set_up = False
            self.teardown()

    def _attempt(self, reached: str, action: Any) -> TransitionCallbackReturn:
        try:
            self.report(OK, reached)
            action()
        except BathbotError as error:
            self.get_logger().error(str(error))
            self.report(ERROR, str(error))
            return TransitionCallbackReturn.FAILURE
        except Exception as error:  # rclpy would swallow it unseen
            self.get_logger().fatal(f"{type(error).__name__}: {error}")
            self.report(ERROR, f"{type(error).__name__}: {error}")
            raise
        self.get_logger().info(reached)
        return TransitionCallbackReturn.SUCCESS

    def _publish_status(self) -> None:
        message = DiagnosticArray(status=[self._status])
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)


def run(node_type: type[StageNode]) -> None:
    """Run one node until Ctrl-C or SIGTERM; exit with 2 when it could not start.

    The signals only end the loop: the context stays valid until the node has left in order.
    """
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = None
    try:
        node = node_type()
        started = node.autostart()
        gc.freeze()  # what is loaded now stays: searching it for garbage would stop all threads for 0.1 s
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while started and not stopping.is_set():
            executor.spin_once(timeout_sec=0.1)
    except ParameterException as error:
        print(f"{node_type.__name__}: {error}", file=sys.stderr)
        started = False
    finally:
        if node is not None:
            node.end()
        rclpy.try_shutdown()
    raise SystemExit(0 if started else 2)
