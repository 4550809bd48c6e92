"""The graph as separate processes: start them, notice a death, leave nothing behind."""

import ctypes
import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from bathbot_bringup.errors import ProcessError
from bathbot_bringup.graph.interruption import SIGNALS, held_back

_PR_SET_PDEATHSIG = 1
_LIBC = ctypes.CDLL(None)
_POLL = 0.05  # [s]
_LOG_PREFIX = re.compile(r"^\[[A-Z]+\] \[[0-9.]+\] \[[^]]*\]: ")  # severity, time and name of a ROS log line


class Child(NamedTuple):
    """One running process of the graph."""

    name: str
    process: subprocess.Popen
    log: Path
    last: bool = False  # whether it ends only when the others have

    def last_line(self) -> str:
        """Quote the last line that tells something: an error or loose text before mere information."""
        lines = [line.strip() for line in self.log.read_text(encoding="utf-8", errors="replace").splitlines()]
        lines = [line for line in lines if line]
        telling = [line for line in lines if not line.startswith(("[INFO]", "[DEBUG]"))]
        return _LOG_PREFIX.sub("", (telling or lines or [""])[-1])


def node_environment(logs: Path) -> dict[str, str]:
    """Build the environment of a node's process: this one's, with one thread per number cruncher."""
    single = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    return {
        **os.environ,
        **dict.fromkeys(single, "1"),
        "ROS_LOG_DIR": str(logs / "ros"),
        "RCUTILS_COLORIZED_OUTPUT": "0",
        "PYTHONUNBUFFERED": "1",
    }


def isolated_environment(domain: int, logs: Path) -> dict[str, str]:
    """Build the environment of a graph that shall hear nobody else: its own domain."""
    return {**node_environment(logs), "ROS_DOMAIN_ID": str(domain)}


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Ignore Ctrl-C and its like while processes are being ended; a second one must not leave any behind."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, signal.SIG_IGN) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _end_with_parent() -> None:
    """Ask the kernel to interrupt this process when the one that started it is gone."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGINT)


Patience = Sequence[tuple[signal.Signals, float]]
"""Signals to send one after the other, and how long to wait after each [s]."""
NODE_PATIENCE: Patience = ((signal.SIGINT, 8.0), (signal.SIGTERM, 3.0), (signal.SIGKILL, 2.0))


class ProcessGroup:
    """Processes that live and end together; use it as a context manager."""

    def __init__(self, logs: Path, environment: dict[str, str], patience: Patience = NODE_PATIENCE) -> None:
        """Remember how to start and to end processes.

        Args:
            logs: Folder for the lines of each process, one file per name.
            environment: Of every process.
            patience: How they are ended: asked, urged, forced.
        """
        logs.mkdir(parents=True, exist_ok=True)
        self._logs, self._environment, self._patience = logs, environment, patience
        self.children: list[Child] = []

    def __enter__(self) -> "ProcessGroup":
        """Begin with no process."""
        return self

    def __exit__(self, *_: object) -> None:
        """End all that were started, whatever happened."""
        self.stop()

    def start(self, name: str, command: Sequence[str], niceness: int = 0, last: bool = False) -> Child:
        """Start one process in a group of its own, so that Ctrl-C reaches only this program.

        Args:
            name: Of the node; its log is named so.
            command: Program and arguments.
            niceness: How much more willing to wait than this program the process is, 0..19.
            last: Whether it ends only when the others have: the arm needs its controller to leave the skin.
        """
        log = self._logs / f"{name}.log"
        with held_back(), log.open("wb") as output:  # nobody would end a process that is not in the list
            process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                env=self._environment, process_group=0, preexec_fn=_end_with_parent,
            )  # fmt: skip
            child = Child(name, process, log, last)
            self.children.append(child)
        if niceness:
            os.setpriority(
                os.PRIO_PROCESS, process.pid, min(os.getpriority(os.PRIO_PROCESS, 0) + niceness, 19)
            )
        return child

    def check(self) -> None:
        """Notice a death.

        Raises:
            ProcessError: Names the first process that has ended, with its last line.
        """
        for child in self.children:
            code = child.process.poll()
            if code is not None:
                how = f"was ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
                raise ProcessError(child.name, how, child.last_line(), str(child.log), code)

    def wait_until(self, ready: Callable[[str], bool], timeout: float) -> None:
        """Wait until `ready(name)` was true for every process.

        Args:
            ready: Asked again and again for each name until true; may take a moment itself.
            timeout: For all together [s].

        Raises:
            ProcessError: When one dies, or is not ready in time.
        """
        deadline = time.monotonic() + timeout
        waiting = list(self.children)
        while waiting:
            self.check()
            waiting = [child for child in waiting if not ready(child.name)]
            if waiting and time.monotonic() > deadline:
                late = waiting[0]
                raise ProcessError(
                    late.name, f"was not active within {timeout:.0f} s", late.last_line(), str(late.log)
                )
            time.sleep(_POLL)

    def stop(self) -> None:
        """End every process, those that are `last` when the others have ended."""
        with _undisturbed():
            for last in (False, True):
                self._end([child for child in self.children if child.last is last])
        self.children.clear()

    def _end(self, children: Sequence[Child]) -> None:
        for number, seconds in self._patience:
            alive = [child for child in children if child.process.poll() is None]
            for child in alive:
                child.process.send_signal(number)
            deadline = time.monotonic() + seconds
            while any(child.process.poll() is None for child in alive) and time.monotonic() < deadline:
                time.sleep(_POLL)
