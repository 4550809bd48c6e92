"""Settings as ROS parameters: declared with description, range and read-only; read back with their types."""

import math
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterValueException
from rclpy.node import Node

from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.node.parameters import Setting, declared

_ALWAYS_ALLOWED = ("autostart", "use_sim_time", "start_type_description_service")
_AUTOSTART = Setting(True, "Whether the node configures and activates itself; false: a manager does")
_LARGEST = 2**63 - 1  # of an integer parameter


def descriptor(setting: Setting) -> ParameterDescriptor:
    """What `ros2 param describe` tells; its ranges are closed, so the rule stands beside them in words.

    Read-only, for a setting is read once, on configure; of dynamic type, for `-p rate:=5` is no float to ROS.
    """
    told = ParameterDescriptor(
        description=setting.description,
        additional_constraints=setting.rule,
        read_only=True,
        dynamic_typing=True,
    )
    if math.isinf(setting.least) and math.isinf(setting.most):
        return told
    if type(setting.default) is float:
        told.floating_point_range = [
            FloatingPointRange(from_value=float(setting.least), to_value=float(setting.most))
        ]
    elif type(setting.default) is int:
        ends = (int(min(max(end, -_LARGEST), _LARGEST)) for end in (setting.least, setting.most))
        least, most = ends
        told.integer_range = [IntegerRange(from_value=least, to_value=most, step=setting.step)]
    return told


def declare(node: Node, settings_type: type) -> None:
    """Declare a parameter for each setting, and `autostart`."""
    node.declare_parameter("autostart", True, descriptor(_AUTOSTART))
    for name, setting in declared(settings_type).items():
        default = list(setting.default) if isinstance(setting.default, tuple) else setting.default
        try:
            node.declare_parameter(name, default, descriptor(setting))
        except InvalidParameterValueException:  # `read` refuses it on configure, in this project's words
            node.declare_parameter(name, default, descriptor(setting), ignore_override=True)


def read(node: Node, settings_type: type) -> Any:
    """Build the settings from the parameters.

    Raises:
        SettingsError: On an unknown name or a wrong type.
        BathbotError: From the settings themselves, on a value outside its meaning.
    """
    known, given = declared(settings_type), node._parameter_overrides
    for name in given:
        if name not in known and name not in _ALWAYS_ALLOWED and not name.startswith("qos_overrides"):
            raise SettingsError(f"unknown parameter {name}; known are {', '.join(known)}")
    values = {}
    for name, setting in known.items():
        value = given[name].value if name in given else node.get_parameter(name).value
        values[name] = _convert(name, value, setting.default)
    return settings_type(**values)


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
