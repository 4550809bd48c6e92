import pytest
from bathbot_perception.detection.throughput import WINDOW, Throughput


def test_the_rate_is_that_of_the_window():
    meter = Throughput(0.0)
    for index in range(100):
        meter.add(index * 0.1, 0.02, 0.05, 2)
    recent = meter.recent(9.95)
    assert float(recent.values["fps"]) == pytest.approx(10.0, abs=0.4)
    assert recent.values["detection_ms"] == "20.0"
    assert recent.values["latency_ms"] == "50.0"
    assert recent.regions == 2 * recent.pictures


def test_old_pictures_are_forgotten():
    meter = Throughput(0.0)
    meter.add(1.0, 0.02, 0.05, 2)
    assert meter.recent(1.0 + 2 * WINDOW).pictures == 0


def test_an_error_lasts_until_a_picture_succeeds():
    meter = Throughput(0.0)
    meter.fail("wrong topic")
    assert meter.recent(1.0).error == "wrong topic"
    meter.add(1.1, 0.02, 0.05, 0)
    assert meter.recent(1.2).error == ""
