"""Installed message types: the class of one, and the definitions of all, so that a bag explains itself."""

import importlib
from functools import cache
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from bathbot_bringup.errors import BagError, InputError
from bathbot_bringup.graph.installation import message_folders


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


def _types_of(package: str, folder: Path) -> dict:
    types: dict = {}
    for file in sorted(folder.glob("*.msg")):
        types.update(get_types_from_msg(file.read_text(encoding="utf-8"), f"{package}/msg/{file.stem}"))
    return types


@cache
def installed_types() -> Typestore:
    """Collect Jazzy's standard types and those of every installed interface package.

    Raises:
        BagError: When an installed definition cannot be read.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    standard = {name.split("/")[0] for name in store.fielddefs}
    for package, folder in message_folders().items():
        if package in standard:
            continue
        try:
            store.register(_types_of(package, folder))
        except TypesysError as error:
            reason = str(error).splitlines()[0]
            raise BagError(
                f"message definitions in {folder} are broken: {reason}; reinstall {package}"
            ) from error
    return store
