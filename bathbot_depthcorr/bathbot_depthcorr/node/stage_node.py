"""The frame of every node: lifecycle with autostart, parameters from one dataclass, diagnostics.

A stage overrides `setup` and `start`; what it makes there by the methods of `EndpointOwner` ends by
itself. A `BathbotError` raised in either becomes one log line, a diagnostic and a failed transition.
"""

from collections.abc import Callable
from typing import Any

from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node import parameters_node
from bathbot_depthcorr.node.dds.participant_node import joining
from bathbot_depthcorr.node.dds.reach import Reach, seen_by
from bathbot_depthcorr.node.diagnostic_node import ERROR, OK, WARN, Diagnostic
from bathbot_depthcorr.node.endpoints_node import LATCHED, EndpointOwner
from bathbot_depthcorr.node.lifetime import Lifetime

__all__ = ["ERROR", "LATCHED", "OK", "WARN", "StageNode"]
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class StageNode(EndpointOwner):
    """A lifecycle node whose parameters are the fields of one settings dataclass."""

    def __init__(self, name: str, settings_type: type, **options: Any) -> None:
        """Declare a parameter for each setting.

        Args:
            name: Of the node.
            settings_type: Dataclass whose fields are made by `parameters.setting`.
            options: Of rclpy's `Node`, such as `parameter_overrides`.
        """
        with joining(options.get("context")) as wanted:
            super().__init__(name, **options)
        if wanted is not Reach.USER:
            self.get_logger().warning(f"seen and commanded by {seen_by(wanted)}")
        self._settings_type = settings_type
        self._configured, self._active = Lifetime(), Lifetime()
        parameters_node.declare(self, settings_type)
        self.diagnostic = Diagnostic(self, "not configured")

    def setup(self, settings: Any) -> None:
        """Load what the stage needs; runs on configure, and what it makes lasts until cleanup."""

    def start(self) -> None:
        """Begin to work; runs on activate, and what it makes lasts until deactivation or the end."""

    def stop(self) -> None:
        """End what `start` began beside its endpoints and threads, once no source calls any more."""

    def report(self, level: bytes, message: str, **values: Any) -> None:
        """Set this node's diagnostic; it is sent every second, and at once when the message changes."""
        self.diagnostic.report(level, message, **values)

    def now(self) -> float:
        """ROS time [s]."""
        return self.get_clock().now().nanoseconds * 1e-9

    def autostart(self) -> bool:
        """Configure and activate unless a manager shall do so; tell whether that worked."""
        if not self.get_parameter("autostart").value:
            return True
        return self.trigger_configure() == SUCCESS and self.trigger_activate() == SUCCESS

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters and set up."""
        self.lifetime = self._configured
        return self._attempt("configured", self._set_up, self._configured.close)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to work."""
        self.lifetime = self._active
        if self._attempt("active", self.start, self._active.close) != SUCCESS:
            return FAILURE
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop working."""
        self._attempt("inactive", self._halt)
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of what `setup` loaded."""
        return self._attempt("not configured", self._configured.close)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop from any state."""
        if state.label == "active":
            self._attempt("inactive", self._halt)
        return self._attempt("shut down", self._configured.close)

    def end(self) -> None:
        """Leave in order, from whatever state the node is in."""
        if self._state_machine.current_state[1] in ("unconfigured", "inactive", "active"):
            self.trigger_shutdown()
        self.destroy_node()

    def _set_up(self) -> None:
        self.setup(parameters_node.read(self, self._settings_type))

    def _halt(self) -> None:
        self._active.close_sources()
        try:
            self.stop()
        finally:
            self._active.close()

    def _attempt(
        self, reached: str, action: Callable[[], None], undo: Callable[[], None] = lambda: None
    ) -> TransitionCallbackReturn:
        try:
            self.report(OK, reached)
            action()
        except BathbotError as error:
            self.get_logger().error(str(error))
            self.report(ERROR, str(error))
            undo()
            return FAILURE
        except Exception as error:  # rclpy would swallow it unseen
            self.get_logger().fatal(f"{type(error).__name__}: {error}")
            self.report(ERROR, f"{type(error).__name__}: {error}")
            undo()
            raise
        self.get_logger().info(reached)
        return SUCCESS
