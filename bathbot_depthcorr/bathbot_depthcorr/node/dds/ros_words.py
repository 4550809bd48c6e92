"""What ROS complains about when a process begins, in words that say what was wrong and what to try."""

import os
import re
from collections.abc import Mapping

from bathbot_depthcorr.errors import SettingsError

DOMAINS = range(233)
"""As many as DDS has ports for."""
_DOMAIN = "ROS_DOMAIN_ID"
_UNREADABLE = re.compile(r"Couldn't parse [^']*'(?P<argument>(?P<flag>\S+)(?: .*?)?)'\.")
_WHERE = re.compile(r", at /\S+\.c:\d+")  # lines of the source of ROS
_NOTATION = {
    "-p": "-p name:=value, and lists of one type",
    "--param": "--param name:=value",
    "-r": "-r from:=to without spaces, such as -r __ns:=/bath",
    "--remap": "--remap from:=to without spaces",
    "--params-file": "--params-file FILE, a YAML file that is there",
    "--log-level": "--log-level debug, info, warn, error or fatal",
}


def domain(environment: Mapping[str, str] = os.environ) -> int | None:
    """The DDS domain that the environment asks for; None where it asks for none.

    Raises:
        SettingsError: When there is no such domain.
    """
    said = environment.get(_DOMAIN, "")
    if not said:
        return None
    if not (said.isdecimal() and int(said) in DOMAINS):
        raise SettingsError(f"{_DOMAIN} is {said!r}; it must be a whole number, 0 to {DOMAINS[-1]}")
    return int(said)


def told(error: Exception) -> str:
    """Say in one line what `rclpy.init` refused."""
    said = " ".join(str(error).split())
    if found := _UNREADABLE.search(said):
        notation = _NOTATION.get(found["flag"], "arguments of ROS as its documentation has them")
        return f"the argument {found['argument']!r} after --ros-args cannot be read; write {notation}"
    if "trailing" in said:
        return "the last argument after --ros-args lacks its value; write -p name:=value or -r from:=to"
    if "log directory" in said:
        place = os.environ.get("ROS_LOG_DIR") or os.environ.get("ROS_HOME") or "~/.ros"
        return f"logs cannot be written below {place}; set ROS_LOG_DIR to a folder of yours"
    if said.startswith("["):
        return f"unknown arguments after --ros-args: {said}; known are {', '.join(_NOTATION)}, --enclave"
    return f"ROS cannot begin: {_WHERE.sub('', said)}; see what is set: env | grep ROS"
