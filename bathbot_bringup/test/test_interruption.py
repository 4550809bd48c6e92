"""Ctrl-C ends a wait, also where Python would drop it."""

import os
import signal
import subprocess
import sys
import time

import pytest
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.graph.interruption import (
    SIGNALS,
    Interrupted,
    forget_interruption,
    heed_signals,
    held_back,
    interrupt,
    interrupted_code,
    raise_if_interrupted,
)
from bathbot_bringup.graph.isolation import free_domain, used_ports


class Swallower:
    """Loses whatever is raised while it is destroyed, as Python has it."""

    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.05)  # the handler runs in here


@pytest.fixture(autouse=True)
def as_in_a_terminal():
    """Whoever runs the tests may have had hang-ups ignored, which programs inherit."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture
def handler():
    before = {number: signal.getsignal(number) for number in SIGNALS}
    heed_signals()
    forget_interruption()
    yield
    for number, what in before.items():
        signal.signal(number, what)
    forget_interruption()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interruption_inside_a_destructor_is_remembered(handler):
    one = Swallower()
    del one  # nothing is raised here: that is what Python does
    with pytest.raises(KeyboardInterrupt):
        raise_if_interrupted()
    raise_if_interrupted()  # once is enough


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_an_interruption_elsewhere_is_raised_at_once_with_its_exit_code(handler, number, code):
    with pytest.raises(Interrupted):
        os.kill(os.getpid(), number)
    assert interrupted_code() == code
    forget_interruption()
    raise_if_interrupted()


HUNG_UP = """
import sys, time
from bathbot_bringup.graph.interruption import Interrupted, heed_signals, interrupted_code
heed_signals()
print("ready", flush=True)
try:
    time.sleep(20.0)
except Interrupted:
    print("this goes nowhere", flush=True)
    sys.exit(interrupted_code())
"""


NOHUP = [  # as the command does it; that would also send the output to a file
    sys.executable,
    "-c",
    "import os, signal as s, sys; s.signal(s.SIGHUP, s.SIG_IGN); os.execv(sys.argv[1], sys.argv[1:])",
]


@pytest.mark.graph
@pytest.mark.parametrize(("before", "code"), [([], 129), (NOHUP, 0)], ids=["terminal", "nohup"])
def test_a_closed_terminal_ends_a_program_in_order_unless_it_was_told_not_to(before, code):
    ours, theirs = os.openpty()
    command = [*before, sys.executable, "-c", HUNG_UP.replace("20.0", "1.0") if before else HUNG_UP]
    program = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True)
    os.close(theirs)
    try:
        said = b""
        while b"ready" not in said:
            said += os.read(ours, 100)
        os.close(ours)  # the kernel sends the hang-up
        program.send_signal(signal.SIGHUP)
        assert program.wait(10.0) == code
    finally:
        program.kill()


@pytest.mark.graph
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_wait_for_the_graph_ends_although_python_dropped_the_signal(handler):
    things = [Swallower()]

    def watch():
        if things:
            things.pop()

    with GraphClient("bathbot_test", free_domain(os.getpid(), used_ports())) as client:
        client.watch = watch
        with pytest.raises(KeyboardInterrupt):
            client.spin_until(lambda: False, 10.0)
        assert not client.spin_until(lambda: False, 0.05)  # cleaning up is not interrupted again


def test_what_must_not_be_left_half_done_is_done_first(handler):
    done = []

    def work():
        with held_back():
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.05)
            done.append("all of it")
        done.append("more")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == ["all of it"]
    assert signal.getsignal(signal.SIGINT) is interrupt
