"""Calls at a steady rate, none after the end, and a failure that is not overlooked."""

import signal
import threading
import time

from bathbot_scrub.rm65.timing.beat import Ticker


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
