"""Message classes by name, for topics whose type is known only at run time."""

import importlib
from typing import Any

from bathbot_bringup.errors import InputError


def message_class(name: str) -> Any:
    """Load the class of a message type such as `std_msgs/msg/Header`.

    Raises:
        InputError: When the package or the message is not installed.
    """
    package, _, message = name.partition("/msg/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), message)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(
            f"message type {name!r} is not installed; install the package {package or name!r}"
        ) from error
