"""What is installed: the version, and where configuration, launch files and message definitions lie.

In a source checkout they lie beside the inner package; after `colcon build` they lie in
`share/<package>` of a prefix. The checkout wins, so an edited file counts at once.
"""

import os
import sys
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version
from importlib.util import find_spec
from pathlib import Path

from bathbot_bringup.errors import InputError

SIM_CALIBRATION = Path(__file__).parents[1] / "sim" / "data" / "sim_d455_calibration.npz"
"""Depth calibration of the simulated camera, from `bathbot simulate board` and `bathbot calibrate depth`."""
SIM_HAND_EYE = "sim_hand_eye.yaml"
"""Configuration of this package: made by `bathbot simulate marker` and `bathbot calibrate hand-eye`."""


def version() -> str:
    """Give the version of the installed distribution: of the pip project, or of the colcon package."""
    for name in ("bathbot", "bathbot_bringup"):
        try:
            return installed_version(name)
        except PackageNotFoundError:
            continue
    return "unknown"


def prefixes() -> list[Path]:
    """Give the install prefixes to search: those of AMENT_PREFIX_PATH, then the one of this Python."""
    listed = [Path(entry) for entry in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if entry]
    here = Path(sys.prefix)
    return listed if here in listed else [*listed, here]


def package_folder(package: str) -> Path:
    """Find the folder that holds `config/` and `launch/` of a package.

    Raises:
        InputError: When the package is neither a checkout nor installed.
    """
    spec = find_spec(package)
    if spec is not None and spec.origin is not None:
        checkout = Path(spec.origin).parents[1]
        if (checkout / "package.xml").is_file():
            return checkout
    for prefix in prefixes():
        if (prefix / "share" / package).is_dir():
            return prefix / "share" / package
    raise InputError(f"package {package} is not installed; run `make setup`, or source install/setup.bash")


def config_file(package: str, name: str) -> Path:
    """Find `config/<name>` of a package.

    Raises:
        InputError: When there is no such file; the message lists those that exist.
    """
    folder = package_folder(package) / "config"
    file = folder / name
    if not file.is_file():
        known = ", ".join(sorted(entry.name for entry in folder.glob("*"))) or "none"
        raise InputError(f"{package} has no configuration {name}; there are {known}")
    return file


def message_folders() -> dict[str, Path]:
    """Map each installed interface package to its folder of `.msg` files; the first prefix wins."""
    folders: dict[str, Path] = {}
    for prefix in prefixes():
        for folder in sorted((prefix / "share").glob("*/msg")):
            folders.setdefault(folder.parent.name, folder)
    return folders
