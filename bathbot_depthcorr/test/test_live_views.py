"""Views gathered from a stream: each still pose once, and only if it serves."""

import re

import cv2
import numpy as np
import pytest
from bathbot_depthcorr.calibration.live_views import HOLD, LiveViews
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.ros.camera_health import CameraHealth
from bathbot_depthcorr.views.bag_views import read_boards
from depthcorr_bag import BOARD, COLOUR, drawn, poses, record
from depthcorr_wall import Sensor, blurred
from numpy.testing import assert_allclose

STEP = 0.1  # [s]


@pytest.fixture(scope="module")
def sensor():
    return Sensor(seed=2, width=424, height=240, least_depth=0.2)


class Stream:
    """Feeds a `LiveViews` and looks at whatever it offers."""

    def __init__(self, sensor):
        self.live = LiveViews(BOARD, COLOUR, sensor.factory)
        self.sensor, self.stamp, self.rng, self.looks = sensor, 100.0, np.random.default_rng(3), []

    def show(self, pose, pictures=8, paint=lambda colour, number: colour, depth_share=1.0):
        normal = -pose[:3, 2]
        truth = self.sensor.truth(Plane(normal, float(normal @ pose[:3, 3])))
        frozen, colour = blurred(self.rng, truth.shape, 3.0, 0.05), drawn(pose.tobytes())
        for number in range(pictures):
            self.stamp += STEP
            noisy = np.clip(paint(colour, number) + self.rng.normal(0.0, 1.0, colour.shape), 0, 255)
            depth = self.sensor.frame(truth, self.rng, frozen)
            depth[int(depth_share * len(depth)) :] = np.nan
            self.live.push_depth(self.stamp, depth)
            self.live.push_colour(self.stamp, noisy.astype(np.uint8))
            if (moment := self.live.still_moment()) is not None:
                self.looks.append(self.live.take(moment))
        return self.looks[-1] if self.looks else None


@pytest.fixture
def stream(sensor):
    return Stream(sensor)


def test_each_still_pose_is_taken_once(stream):
    for pose in poses(3):
        stream.show(pose, pictures=15)
    assert [look.taken for look in stream.looks] == [True] * 3
    assert [look.pose for look in stream.looks] == stream.live.poses
    assert stream.looks[0].words.startswith("view 1: ")


def test_a_pose_must_last(stream):
    assert stream.show(next(poses(1)), pictures=int(HOLD / STEP)) is None
    assert stream.show(next(poses(1)), pictures=2).taken


def test_the_same_pose_again_is_told(stream):
    first, second = poses(2)
    stream.show(first)
    stream.show(second)
    look = stream.show(first)
    assert (look.taken, look.words) == (False, "this pose is there already; move on")
    assert len(stream.live.boards) == 2


@pytest.mark.parametrize(("options", "words"), [
    pytest.param({"paint": lambda colour, _: cv2.blur(colour, (9, 1))}, r"blurred: edges [89]", id="blurred"),
    pytest.param({"paint": lambda colour, _: 0 * colour + 90}, "no chessboard of 11x8", id="no board"),
    pytest.param({"depth_share": 0.1}, "wall on .% of the picture only, 20% are needed", id="no depth"),
])  # fmt: skip
def test_what_does_not_serve(stream, options, words):
    look = stream.show(next(poses(1)), **options)
    assert not look.taken
    assert re.search(words, look.words)
    assert not stream.live.boards


def test_a_moving_camera_gives_no_moment_but_is_seen(stream):
    pose = next(poses(1))
    assert stream.show(pose, paint=lambda colour, number: np.roll(colour, 15 * (number - 4), axis=1)) is None
    assert stream.live.glance().distance == pytest.approx(0.6, abs=0.05)


def test_nothing_seen_yet(sensor):
    live = LiveViews(BOARD, COLOUR, sensor.factory)
    assert live.glance() is None
    assert live.still_moment() is None


def test_a_stream_gives_what_a_bag_gives(sensor, stream, tmp_path):
    """The same poses, recorded or live: corners and depth agree within their noise."""
    record(tmp_path / "bag", sensor, 3)
    recorded = read_boards(tmp_path / "bag", BOARD)
    for pose in poses(3):
        stream.show(pose)
    live = stream.live.recording(CameraHealth("7", 40.0))
    assert (live.unit.serial, live.unit.temperature) == ("7", 40.0)
    assert live.colour_camera == recorded.colour_camera
    for one, other in zip(live.boards, recorded.boards, strict=True):
        assert_allclose(one.corners, other.corners, atol=0.2)
        assert np.nanmedian(np.abs(one.depth / other.depth - 1.0)) < 5e-3
