"""Ctrl-C ends a wait, also where Python would drop it."""

import os
import signal
import time

import pytest
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.graph.interruption import forget_interruption, held_back, interrupt, raise_if_interrupted
from bathbot_bringup.graph.isolation import free_domain, used_ports


class Swallower:
    """Loses whatever is raised while it is destroyed, as Python has it."""

    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.05)  # the handler runs in here


@pytest.fixture
def handler():
    before = signal.signal(signal.SIGINT, interrupt)
    forget_interruption()
    yield
    signal.signal(signal.SIGINT, before)
    forget_interruption()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interruption_inside_a_destructor_is_remembered(handler):
    one = Swallower()
    del one  # nothing is raised here: that is what Python does
    with pytest.raises(KeyboardInterrupt):
        raise_if_interrupted()
    raise_if_interrupted()  # once is enough


def test_an_interruption_elsewhere_is_raised_at_once(handler):
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)
    forget_interruption()
    raise_if_interrupted()


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
