"""A made-up run over the simulated body, whose every number is known beforehand."""

import json

import numpy as np
import pytest
from bags import write_bag
from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.bathing.steps import Sighting
from bathbot_bringup.report.report import Outcome, report_run
from bathbot_bringup.report.run_data import read_run
from bathbot_bringup.report.summary_table import spread, table_rows
from bathbot_bringup.report.truth import Truth
from bathbot_depthcorr.ros.messages import stamp_from_seconds
from bathbot_localize.messages import pose_from_transform
from bathbot_localize.target.target import Target, pose_from_normal
from bathbot_scrub.arm.states import State
from geometry_msgs.msg import PoseStamped, Vector3
from nav_msgs.msg import Path
from std_msgs.msg import Header

from bathbot_msgs.msg import ArmState, ContactTarget, ContactTargets, ScrubSegment, SimContact

EPOCH = 1_700_000_000.0
PIXEL = (424.0, 240.0)
SIDEWAYS, STRAY, COMPRESSION = 0.003, 0.0015, 0.005  # [m] of the target, of the path, of the bristles
COUNT, SPEED = 101, 0.04


class Writer:
    """Collects messages by topic and writes them as a bag in the order of their time."""

    def __init__(self):
        self.rows = []

    def put(self, topic, time, message):
        self.rows.append((time, topic, message))

    def write(self, target):
        write_bag(target, [
            (topic, f"{type(message).__module__.split('.')[0]}/msg/{type(message).__name__}", int(time * 1e9),
             message)
            for time, topic, message in sorted(self.rows, key=lambda row: row[0])
        ], lost="7")  # fmt: skip


def header(time):
    return Header(stamp=stamp_from_seconds(time), frame_id="base_link")


@pytest.fixture(scope="module")
def truth(settings):
    return Truth(settings, EPOCH)


@pytest.fixture(scope="module")
def settings(tmp_path_factory):
    return DemoSettings("Trunk_skin", 0, "still", tmp_path_factory.mktemp("run"))


def on_skin(truth):
    """The point of the skin before the middle of the picture, and its outward normal."""
    ray = truth.T_base_colour[:3, :3] @ truth.colour.directions(np.array(PIXEL))
    origin = truth.T_base_colour[:3, 3]
    point = truth.surface.true_point(origin, ray, 0.0)
    _, normals, _ = truth.surface.distance(origin[None], ray[None] / np.linalg.norm(ray), 0.0)
    return point, normals[0]


@pytest.fixture(scope="module")
def report(settings, truth):
    """The run: a straight path of 0.2 m, strayed from by 1.5 mm, half of it without contact."""
    point, normal = on_skin(truth)
    pose = pose_from_normal(point, normal)
    path = np.tile(pose, (COUNT, 1, 1))
    path[:, :3, 3] += np.outer(0.002 * np.arange(COUNT) - 0.1, pose[:3, 1])
    writer, begin = Writer(), EPOCH + 10.0
    found = pose.copy()
    found[:3, 3] += SIDEWAYS * pose[:3, 0]
    target = ContactTarget(region="Trunk_skin", score=0.9, pixel=np.array(PIXEL))
    target.pose.pose = pose_from_transform(found)
    writer.put("/contact_targets", EPOCH + 5.0, ContactTargets(header=header(EPOCH + 5.0), targets=[target]))
    for index in range(4):
        part = path[26 * index : 26 * (index + 1)]
        writer.put("/scrub_segments", begin - 0.5 + 0.1 * index, ScrubSegment(
            header=header(begin), path_id=7, index=index, last=index == 3, region="Trunk_skin", spacing=0.002,
            poses=[pose_from_transform(entry) for entry in part]))  # fmt: skip
    poses = [PoseStamped(pose=pose_from_transform(entry)) for entry in path]
    writer.put("/planned_path", begin - 0.6, Path(header=header(begin), poses=poses))
    for time in np.arange(begin - 2.0, begin + 8.0, 0.02):
        along = SPEED * (time - begin) - 0.105
        head = pose.copy()
        head[:3, 3] += along * pose[:3, 1] + STRAY * pose[:3, 0]
        bent = COMPRESSION if along < 0.0 else -0.002
        force = 400.0 * max(bent, 0.0) if time > begin else 0.0
        writer.put("/sim_contact", time, SimContact(
            header=header(time), head=pose_from_transform(head), compression=bent, force=Vector3(x=force),
            part="Trunk_skin"))  # fmt: skip
    for time in np.arange(begin - 2.0, begin + 8.0, 0.05):
        following = begin - 0.5 < time < begin + 6.0
        writer.put("/arm_state", time, ArmState(
            header=header(time), state=State.CONTACT if following else State.FREE,
            path_id=7 if following else 0,
            distance_along=max(SPEED * (time - begin) - 0.005, 0.0) if following else 0.0,
            force_threshold=10.0, period=0.01, period_deviation_p99=0.0004))  # fmt: skip
    writer.write(settings.out / "run.mcap")
    sighting = Sighting(EPOCH + 5.0, Target("Trunk_skin", 0.9, found, np.eye(6), PIXEL, 20.0, 100))
    return report_run(settings, Outcome("", EPOCH, sighting, {"scrub": 5.0}, 30.0))


def test_the_localisation_error_is_the_displacement_of_the_target(report):
    assert report["localization_error_mm"] == pytest.approx(1000 * SIDEWAYS, abs=0.01)
    assert np.linalg.norm(report["localization_error_axes_mm"]) == pytest.approx(1000 * SIDEWAYS, abs=0.01)


def test_the_path_error_is_the_stray(report):
    assert report["path_y_error_max_mm"] == pytest.approx(1000 * STRAY, abs=0.01)
    assert report["path_length_m"] == pytest.approx(0.2, abs=1e-6)


def test_half_of_the_path_was_in_contact(report):
    assert report["contact_fraction"] == pytest.approx(0.5, abs=0.02)


def test_the_forces_are_those_of_the_bristles(report):
    assert report["force_peak_n"] == pytest.approx(2.0)
    assert report["force_threshold_n"] == 10.0
    assert report["force_mean_n"] == pytest.approx(1.0, abs=0.1)


def test_what_the_recording_lacks_is_told(report):
    assert report["messages_lost"] == 7
    assert ("messages that the recording lacks", "7") in table_rows(report)


def test_the_period_is_that_of_the_driver(report):
    assert report["command_period_p99_dev_ms"] == pytest.approx(0.4)


def test_the_summary_is_in_its_file_and_says_simulated(report, settings):
    stored = json.loads((settings.out / "summary.json").read_text())
    assert stored == report
    assert (stored["simulated"], stored["done"], stored["seed"], stored["region"]) == (
        True,
        True,
        0,
        "Trunk_skin",
    )
    assert {"coverage", "duration_s", "version", "stages_s"} <= stored.keys()


def test_the_page_stands_alone_and_says_simulated(report, settings):
    page = (settings.out / "report.html").read_text()
    assert "SIMULATED" in page
    assert page.count("data:image/png;base64,") == 4
    assert "http" not in page


def test_only_whole_files_lie_in_the_folder(report, settings):
    names = {file.name for file in settings.out.iterdir()}
    assert names == {"run.mcap", "metadata.yaml", "summary.json", "report.html"}


def test_the_bag_is_read_back_as_it_was_meant(report, settings):
    run = read_run(settings.out / "run.mcap")
    assert (len(run.paths), len(run.paths[0].T_base_head), run.paths[0].complete) == (1, COUNT, True)
    assert run.planned_poses == COUNT
    assert list(run.paths[0].segment[[0, -1]]) == [0, 3]


def test_a_run_without_a_bag_has_a_summary_that_says_why(tmp_path):
    settings = DemoSettings("Trunk_skin", 0, "still", tmp_path)
    summary = report_run(settings, Outcome("look failed: nobody is there", EPOCH, None, {}, 3.0))
    assert (summary["done"], summary["failure"]) == (False, "look failed: nobody is there")
    assert summary["contact_fraction"] is None
    assert json.loads((tmp_path / "summary.json").read_text()) == summary


def test_a_run_that_lost_its_bag_is_not_done(tmp_path):
    settings = DemoSettings("Trunk_skin", 0, "still", tmp_path)
    summary = report_run(settings, Outcome("", EPOCH, None, {}, 3.0))
    assert not summary["done"]
    assert "there is no bag" in summary["failure"]


def test_a_run_that_never_touched_has_no_path_error(tmp_path):
    writer = Writer()
    writer.put("/arm_state", EPOCH + 1.0, ArmState(header=header(EPOCH + 1.0)))
    writer.write(tmp_path / "run.mcap")
    settings = DemoSettings("Trunk_skin", 0, "still", tmp_path)
    summary = report_run(settings, Outcome("look failed", EPOCH, None, {}, 3.0))
    assert summary["path_y_error_max_mm"] is None
    assert summary["contact_fraction"] == 0.0
    assert "-" in dict(table_rows(summary)).values()


def test_many_runs_are_summed_up():
    runs = [
        {"done": True, "duration_s": 40.0, "coverage": 0.9},
        {"done": True, "duration_s": 60.0, "coverage": None},
    ]
    numbers = spread(runs)
    assert numbers["duration_s"] == {"count": 2, "mean": 50.0, "std": 10.0, "min": 40.0, "max": 60.0}
    assert numbers["coverage"]["count"] == 1
    assert "force_peak_n" not in numbers
