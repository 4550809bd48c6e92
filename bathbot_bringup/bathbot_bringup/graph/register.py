"""Which graphs of this user run now, so that a command finds the one it is for: a file each."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bathbot_depthcorr.node.dds import ros_words

from bathbot_bringup.errors import InputError


def _folder() -> Path:
    own = os.environ.get("XDG_RUNTIME_DIR") or Path(tempfile.gettempdir()) / f"bathbot-{os.geteuid()}"
    return Path(own) / "bathbot"


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can have put it, or what it lies in, there."""
    return all(one.is_dir() and one.lstat().st_uid == os.geteuid() for one in (folder, folder.parent))


def _own_folder() -> Path:
    folder = _folder()
    folder.parent.mkdir(mode=0o700, exist_ok=True)
    with suppress(PermissionError):  # it is somebody else's, which is said below
        folder.mkdir(mode=0o700, exist_ok=True)
    if not _is_ours(folder):
        raise InputError(f"{folder} is another user's; set XDG_RUNTIME_DIR to a folder of your own")
    return folder


@contextmanager
def alone() -> Iterator[None]:
    """Bathe while nobody else of this user does: two at once hold each other's pictures and arm up.

    Raises:
        InputError: When another program bathes on this machine.
    """
    with (_own_folder() / "bathing.lock").open("a+", encoding="ascii") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.seek(0)
            raise InputError(
                f"process {lock.read()} bathes on this machine already, and two at once hold each other up; "
                "wait for it, or end it with Ctrl-C"
            ) from None
        lock.truncate(0)
        lock.write(str(os.getpid()))
        lock.flush()
        yield


@contextmanager
def registered(domain: int) -> Iterator[None]:
    """Tell of a graph while this lasts.

    Raises:
        InputError: When another user holds the place to tell it at.
    """
    file = _own_folder() / str(domain)
    file.write_text(str(os.getpid()), encoding="ascii")
    try:
        yield
    finally:
        file.unlink(missing_ok=True)


def running_domains() -> list[int]:
    """Domains of the graphs whose processes live."""
    folder, found = _folder(), []
    if not _is_ours(folder):
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
        SettingsError: When ROS_DOMAIN_ID is no domain.
    """
    if wanted is not None:
        return wanted
    said = ros_words.domain()
    if said is not None:
        return said
    found = running_domains()
    if len(found) > 1:
        raise InputError(
            f"{len(found)} graphs run here, on the domains {', '.join(map(str, found))}; say which: --domain"
        )
    return found[0] if found else 0
