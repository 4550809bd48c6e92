"""Which graphs of this user run now, so that a command finds the one it is for: a file each."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bathbot_bringup.errors import InputError


def _folder() -> Path:
    return Path(os.environ.get("XDG_RUNTIME_DIR") or f"/tmp/bathbot-{os.geteuid()}") / "bathbot"


@contextmanager
def registered(domain: int) -> Iterator[None]:
    """Tell of a graph while this lasts."""
    folder = _folder()
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    file = folder / str(domain)
    file.write_text(str(os.getpid()), encoding="ascii")
    try:
        yield
    finally:
        file.unlink(missing_ok=True)


def running_domains() -> list[int]:
    """Domains of the graphs whose processes live."""
    folder, found = _folder(), []
    if not folder.is_dir() or folder.stat().st_uid != os.geteuid():
        return []
    for file in folder.iterdir():
        with suppress(OSError, ValueError):
            os.kill(int(file.read_text(encoding="ascii")), 0)
            found.append(int(file.name))
    return sorted(found)


def find_domain(wanted: int | None) -> int:
    """The domain a command is for: what was asked, else ROS_DOMAIN_ID, else the one graph that runs, else 0.

    Raises:
        InputError: When several run.
    """
    if wanted is not None:
        return wanted
    said = os.environ.get("ROS_DOMAIN_ID", "")
    if said.isdecimal():
        return int(said)
    found = running_domains()
    if len(found) > 1:
        raise InputError(
            f"{len(found)} graphs run here, on the domains {', '.join(map(str, found))}; say which: --domain"
        )
    return found[0] if found else 0
