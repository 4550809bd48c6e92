"""A beat that does not drift; calls at a steady rate, none after the end, and failures that are seen."""

import signal
import threading
import time

from bathbot_scrub.rm65.timing.beat import Beat, Ticker


def test_the_beat_does_not_drift():
    beat, begin = Beat(0.002), time.monotonic()
    for _ in range(50):
        while not beat.passed():
            time.sleep(beat.left())
    assert time.monotonic() - begin >= 50 * 0.002 - 1e-3


def test_a_beat_that_is_brought_forward_falls_due_at_once_and_the_others_follow_from_there():
    beat = Beat(60.0)
    assert beat.left() > 50.0
    assert not beat.passed()
    beat.bring_forward(time.monotonic() - 1.0)
    assert beat.left() == 0.0
    assert beat.passed()
    assert 50.0 < beat.left() <= 60.0
    beat.bring_forward(time.monotonic() + 120.0)  # never later than it was
    assert beat.left() <= 60.0


def test_it_calls_until_it_is_closed():
    ticks = []
    ticker = Ticker(200.0, lambda: ticks.append(time.monotonic()), print)
    deadline = time.monotonic() + 20.0
    while len(ticks) < 20 and time.monotonic() < deadline:
        time.sleep(0.01)
    ticker.close()
    count = len(ticks)
    time.sleep(0.05)
    assert 20 <= len(ticks) == count
    assert ticks[19] - ticks[0] > 0.08  # not in a rush


def test_a_failure_is_told_and_ends_the_process():
    asked = threading.Event()
    before = signal.signal(signal.SIGTERM, lambda *_: asked.set())
    told = []
    try:
        ticker = Ticker(100.0, lambda: 1 / 0, told.append)
        deadline = time.monotonic() + 20.0
        while not asked.is_set() and time.monotonic() < deadline:
            time.sleep(0.01)
        ticker.close()
    finally:
        signal.signal(signal.SIGTERM, before)
    assert asked.is_set()
    assert told == ["ZeroDivisionError: division by zero"]
