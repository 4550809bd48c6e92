import threading
import time

import pytest
from bathbot_depthcorr.node.newest_worker import NewestWorker


class Gate:
    """Work that waits until it is let through."""

    def __init__(self, waiting, **more):
        self.seen, self.failed = [], []
        self.begun, self.open = threading.Semaphore(0), threading.Semaphore(0)
        self.worker = NewestWorker(self.work, self.failed.append, waiting, **more)

    def work(self, item):
        self.begun.release()
        assert self.open.acquire(timeout=10.0)
        self.seen.append(item)
        if item == "bad":
            raise ValueError(item)

    def let_all(self, count):
        for _ in range(count):
            self.open.release()
        for _ in range(count - 1):
            assert self.begun.acquire(timeout=10.0)
        self.worker.close()


@pytest.mark.parametrize("waiting", [1, 3])
def test_the_newest_are_kept_in_order_and_the_rest_is_counted(waiting):
    gate = Gate(waiting)
    gate.worker.put(0)
    assert gate.begun.acquire(timeout=10.0)  # 0 is in work, the others wait
    for item in range(1, 6):
        gate.worker.put(item)
    assert gate.worker.dropped == 5 - waiting
    gate.let_all(1 + waiting)
    assert gate.seen == [0, *range(6 - waiting, 6)]


def test_what_waits_is_done_before_the_end_when_there_is_time_for_it():
    done = []
    worker = NewestWorker(lambda item: (time.sleep(0.01), done.append(item)), print, waiting=10)
    for item in range(5):
        worker.put(item)
    worker.settle(20.0)
    worker.close()
    assert done == [0, 1, 2, 3, 4]


def test_what_waited_too_long_makes_way_for_the_newest():
    gate = Gate(4, patience=0.0)
    gate.worker.put(0)
    assert gate.begun.acquire(timeout=10.0)
    for item in range(1, 5):
        gate.worker.put(item)
    gate.let_all(2)
    assert gate.seen == [0, 4]
    assert gate.worker.dropped == 3


def test_an_error_is_handed_on_and_the_thread_lives():
    gate = Gate(2)
    for item in ("bad", "good"):
        gate.worker.put(item)
    assert gate.begun.acquire(timeout=10.0)
    gate.let_all(2)
    assert [str(error) for error in gate.failed] == ["bad"]
    assert gate.seen == ["bad", "good"]
    assert (gate.worker.done, gate.worker.dropped) == (2, 0)
