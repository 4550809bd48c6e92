import json
import os
import time

import numpy as np
import pytest
from bathbot_bringup.bench.apply import time_apply
from bathbot_bringup.bench.scene import bench_camera, bench_corrections, bench_frames
from bathbot_bringup.bench.stream import arrived, cpu_seconds
from bathbot_bringup.command.arguments import picture_size
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import InputError
from bathbot_depthcorr.models.table import judged_models
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal


@given(
    begin=st.floats(0.0, 3.0),
    sent=st.integers(1, 60),
    lost=st.sets(st.integers(0, 400)),
    rate=st.sampled_from([5.0, 30.0, 90.0]),
    epoch=st.floats(0.0, 1e9),
)
def test_each_frame_that_did_not_come_out_is_counted_once(begin, sent, lost, rate, epoch):
    """The first frame, from which numbers are counted, always came out; stamps carry whole nanoseconds."""
    stamps = [round(epoch + number / rate, 9) for number in range(400) if number not in lost or number == 0]
    first = int(np.ceil((round(epoch, 9) + begin - stamps[0]) * rate))
    missing = {number for number in lost if first <= number < first + sent and number > 0}
    beyond = max(first + sent - 400, 0)
    found = arrived(stamps, stamps[0] + begin, sent, rate)
    assert abs(sent - len(found) - len(missing) - min(beyond, sent)) <= 1  # begin may lie on a frame's time
    assert len(set(found)) == len(found)


def test_lost_frames_by_hand():
    stamps = [10.0, 10.1, 10.3, 10.4, 10.6]
    assert arrived(stamps, 10.05, 5, 10.0) == [10.1, 10.3, 10.4]  # 10.2 and 10.5 are lost
    assert arrived(stamps, 10.05, 2, 10.0) == [10.1]


@pytest.mark.parametrize("model", judged_models())
def test_the_bench_exercises_every_model_where_there_is_depth(model):
    camera = bench_camera(160, 90)
    one, two = bench_frames(camera, 2)
    corrected = bench_corrections(camera)[model].apply(one)
    assert_array_equal(np.isnan(corrected), np.isnan(one))
    assert 1e-4 < np.nanstd(corrected - one) < 0.1
    assert 0.05 < np.isnan(one).mean() < 0.2
    assert not np.array_equal(one, two, equal_nan=True)
    assert_array_equal(one, bench_frames(camera, 1)[0])


class SlowCorrection:
    """Takes a millisecond, for a copy that takes microseconds."""

    def apply(self, depth):
        time.sleep(1e-3)


def test_a_correction_is_timed_in_milliseconds_and_in_copies():
    times = time_apply(SlowCorrection(), np.zeros((90, 160), np.float32))
    assert 1.0 <= times.apply_ms < 10.0
    assert times.copy_ms < 0.5
    assert times.apply_over_copy > 10.0


def test_processor_time_is_that_of_the_process():
    before = cpu_seconds(os.getpid())
    while cpu_seconds(os.getpid()) < before + 0.05:
        sum(range(10_000))
    times = os.times()
    assert cpu_seconds(os.getpid()) == pytest.approx(times.user + times.system, abs=0.1)


@pytest.mark.parametrize("text", ["1280", "1280x", "12800x720", "axb"])
def test_a_bad_size_is_refused(text):
    with pytest.raises(InputError, match="a size is written as width x height"):
        picture_size(text)


def test_a_size_is_width_by_height():
    assert picture_size("848x480") == (848, 480)


@pytest.mark.graph
def test_the_command_streams_to_the_real_node_and_writes_its_numbers(tmp_path, capsys):
    file = tmp_path / "depth.json"
    line = ["bench", "depth", "--size", "320x180", "--rate", "10", "--seconds", "2", "--json", str(file)]
    assert run(line) == 0
    numbers = json.loads(file.read_text())
    assert {"apply_over_copy", "apply_ms", "copy_ms", "node_dropped", "node_cpu"} <= set(numbers)
    assert numbers["frames_sent"] == 20
    assert numbers["frames_got"] == 20 - numbers["node_dropped"] > 0
    assert numbers["node_cpu"] > 0.0
    assert numbers["latency_ms_p50"] > 0.0
    assert "frames dropped by the node" in capsys.readouterr().out
