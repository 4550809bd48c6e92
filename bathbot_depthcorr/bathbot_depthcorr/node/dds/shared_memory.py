"""What Fast DDS keeps in shared memory, pictures among it: open to this user only, gone when its owner is.

Fast DDS lets everybody read its files, whatever the umask. Most have a companion `_el` that their owner keeps
locked as long as it lives.
"""

import fcntl
import os
import stat
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from bathbot_depthcorr.errors import DepthcorrError

FOLDER = Path("/dev/shm")
_PREFIX, _PORT, _LOCK, _MUTEX = "fastrtps_", "fastrtps_port", "_el", "sem.{}_mutex"
_YOUNG = 10.0  # [s]
_MINE_ONLY = stat.S_IRUSR | stat.S_IWUSR


class ForeignMemoryError(DepthcorrError):
    """Somebody else holds the shared memory through which this node would be spoken to."""


def close_to_others(folder: Path = FOLDER) -> None:
    """Let nobody but this user open what this user's participants have laid into shared memory."""
    for path in _files(folder):
        _change(path)


def _change(path: Path) -> None:
    with suppress(FileNotFoundError):  # its owner has just ended
        seen = path.lstat()
        if seen.st_uid == os.geteuid() and stat.S_IMODE(seen.st_mode) != _MINE_ONLY:
            path.chmod(_MINE_ONLY)


def foreign_ports(folder: Path = FOLDER) -> dict[int, int]:
    """Ports of shared memory that another user holds, but root; each with the user's id."""
    found = {}
    for path in _files(folder):
        number = path.name.removeprefix(_PORT)
        if path.name.startswith(_PORT) and number.isdecimal():
            with suppress(FileNotFoundError):  # its owner has just ended
                found[int(number)] = path.lstat().st_uid
    return {port: user for port, user in found.items() if user not in (os.geteuid(), 0)}


def refuse_foreign(ports: range, folder: Path = FOLDER) -> None:
    """Refuse to join a domain whose places in shared memory another user holds.

    Args:
        ports: Those of the domain.
        folder: Of shared memory.

    Raises:
        ForeignMemoryError: With whose they are.
    """
    for port, user in foreign_ports(folder).items():
        if port in ports:
            raise ForeignMemoryError(
                f"user {user} of this machine holds {folder / _PORT}{port}, through which this node would be "
                "spoken to; take another ROS_DOMAIN_ID"
            )


def clean(folder: Path = FOLDER) -> int:
    """Remove what participants of this user left that were killed; the size of it [bytes]."""
    left = [path for path in _files(folder) if not (path.name.endswith(_LOCK) or _young(path) or _held(path))]
    mapped = _mapped() if left else frozenset()
    return sum(
        _remove(part)
        for path in left
        if str(path) not in mapped
        for part in (path, path.with_name(path.name + _LOCK), path.with_name(_MUTEX.format(path.name)))
    )


def _mapped() -> frozenset[str]:
    """Shared memory that a living process has open, as far as this user may know."""
    found: set[str] = set()
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has just ended, or is another user's
            maps = (process / "maps").read_text(errors="replace")
            found |= {line.split(maxsplit=5)[-1] for line in maps.splitlines() if _PREFIX in line}
    return frozenset(found)


def _files(folder: Path) -> Iterator[Path]:
    return folder.glob(f"{_PREFIX}*") if folder.is_dir() else iter(())


def _young(path: Path) -> bool:
    """Whether its owner may still be about to lock it; also when it is gone."""
    try:
        return time.time() - path.lstat().st_ctime < _YOUNG
    except FileNotFoundError:
        return True


def _held(path: Path) -> bool:
    """Whether somebody who lives keeps the lock of a file, or it may not be opened; false without a lock."""
    try:
        descriptor = os.open(path.with_name(path.name + _LOCK), os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


def _remove(path: Path) -> int:
    try:
        seen = path.lstat()
        if seen.st_uid != os.geteuid():
            return 0
        path.unlink()
    except FileNotFoundError:
        return 0
    return seen.st_size
