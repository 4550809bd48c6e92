"""The two kinds of tests of this tree: those marked `graph`, and those that run in this process alone."""

import os
import sys
from collections.abc import Iterator

# As in the nodes: matrices are small here, and threads that wait for one another would take thrice the time.
os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

import pytest
from rclpy.context import Context

# What CPython reports when a process starts or a port opens (docs.python.org/3/library/audit_events.html).
OUTSIDE = {"subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.system", "socket.bind"}
ADVICE = "mark the test `graph`, or test what decides without it"

_init = Context.init
_held = ""  # the test that runs now, if it may not leave this process


def _refuse_outside(event: str, _arguments: tuple) -> None:
    if _held and event in OUTSIDE:
        raise RuntimeError(f"{_held} causes {event}; {ADVICE}")


def _init_in_graph_tests(context: Context, *arguments, **options) -> None:
    if _held:
        raise RuntimeError(f"{_held} initialises rclpy; {ADVICE}")
    _init(context, *arguments, **options)


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Spread `-m "not graph"` over the cores: such tests share nothing. Those of the graph need them all."""
    option, is_worker = config.option, hasattr(config, "workerinput")
    if option.markexpr != "not graph" or is_worker or not config.pluginmanager.has_plugin("xdist"):
        return
    if option.numprocesses is None and not option.usepdb:
        option.numprocesses, option.dist = os.cpu_count(), "loadfile"


def pytest_configure() -> None:
    """Watch from the first test on."""
    sys.addaudithook(_refuse_outside)
    Context.init = _init_in_graph_tests


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Hold a test without the mark, and the fixtures it asks for, to this process."""
    global _held
    _held = "" if item.get_closest_marker("graph") else item.nodeid
    try:
        return (yield)
    finally:
        _held = ""
