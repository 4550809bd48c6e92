"""The version of bathbot."""

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version


def version() -> str:
    """Give the version of the installed distribution: of the pip project, or of the colcon package."""
    for name in ("bathbot", "bathbot_bringup"):
        try:
            return installed_version(name)
        except PackageNotFoundError:
            continue
    return "unknown"
