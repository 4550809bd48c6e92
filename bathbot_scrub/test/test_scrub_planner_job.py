"""The job's thread: bounded queue, and every way to end."""

import time

import numpy as np
import pytest
from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import NotReadyError, SurfaceError
from bathbot_scrub.job.scrub_job import ArmReport, Code, Outcome, ScrubJob, refusal
from bathbot_scrub.path.planner import PathPlanner, Task
from bathbot_scrub.path.surface_map import Sighting
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from bathbot_scrub.segment.segment import refusal as refusal_of
from synthetic_skin import cylinder, plane, target

SETTINGS = ScrubPlannerSettings(arm_state_max_age=30.0, stall_timeout=30.0)  # the tests may be slow


class Rig:
    """A job with an arm that follows one segment each time `follow` is called."""

    def __init__(self, settings=SETTINGS, plan=None):
        self.segments, self.outcome, self.under_head, self.now = [], None, 0, 0.0
        plan = plan or (lambda: PathPlanner(Task(cylinder(), 0.0, target()), settings))
        self.job = ScrubJob(
            7, plan, lambda segment, *_: self.segments.append(segment),
            lambda outcome: setattr(self, "outcome", outcome), lambda: self.now, settings,
        )  # fmt: skip
        self.say()
        self.job.start()

    def say(self, mode=State.CONTACT, path_id=7, done=False, reason=""):
        waiting = len(self.segments) - self.under_head
        along = 0.06 * self.under_head
        self.job.see_arm(ArmReport(mode, reason, path_id, self.under_head, waiting, along, done))

    def wait(self, condition, timeout=20.0):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end
            self.say()
            time.sleep(0.002)

    def end(self):
        self.job.join(20.0)
        return self.outcome


def test_planner_keeps_three_segments_ahead_and_ends_with_the_path():
    rig = Rig()
    while not (rig.segments and rig.segments[-1].last):
        rig.wait(lambda: len(rig.segments) >= rig.under_head + 3 or (rig.segments and rig.segments[-1].last))
        time.sleep(0.02)
        assert len(rig.segments) <= rig.under_head + 3
        rig.under_head += 1
        rig.say()
    rig.say(done=True)
    outcome = rig.end()
    assert (outcome.code, outcome.message, outcome.segments) == (Code.NONE, "", len(rig.segments))
    assert outcome.length > 0.3
    assert [segment.index for segment in rig.segments] == list(range(len(rig.segments)))


def test_older_reports_of_another_path_do_not_count():
    rig = Rig()
    end = time.monotonic() + 20.0
    while time.monotonic() < end and not (len(rig.segments) == 3 and time.monotonic() > end - 19.8):
        rig.job.see_arm(ArmReport(State.CONTACT, "", 6, 40, 0, 2.4, True))
        time.sleep(0.01)
    assert len(rig.segments) == 3
    rig.job.cancel()
    assert rig.end().code == Code.CANCELED


def test_newest_surface_is_planned_on():
    rig = Rig()
    rig.wait(lambda: len(rig.segments) == 3)
    moved = cylinder()
    moved[..., 0] -= 0.004
    rig.job.see_surface(Sighting(1.0, lambda: moved))
    rig.under_head = 2
    rig.wait(lambda: len(rig.segments) == 5)
    assert rig.segments[2].stamp == 0.0
    assert rig.segments[4].stamp == 1.0
    radius = np.hypot(
        rig.segments[4].T_base_heads[-1, 0, 3] - 0.85 + 0.004, rig.segments[4].T_base_heads[-1, 1, 3]
    )
    assert 0.15 - radius == pytest.approx(SETTINGS.compression, abs=3e-4)
    rig.job.cancel()
    rig.end()


@pytest.mark.parametrize(
    ("mode", "code", "words"),
    [(State.RETRACTING, Code.FORCE_LIMIT, "12 N"), (State.HOLD, Code.ARM_STOPPED, "HOLD"),
     (State.FAULT, Code.ARM_STOPPED, "FAULT"), (State.FREE, Code.ARM_STOPPED, "FREE")],
)  # fmt: skip
def test_arm_that_stops_ends_the_job(mode, code, words):
    rig = Rig()
    rig.wait(lambda: len(rig.segments) == 3)
    rig.say(mode, reason="felt 12 N")
    rig.say(State.CONTACT)
    rig.job.join(0.2)
    if mode != State.RETRACTING:
        rig.say(mode, reason="felt 12 N")
    outcome = rig.end()
    assert outcome.code == code
    assert words in outcome.message
    assert len(rig.segments) == 3


def test_a_path_that_was_cut_short_says_why_though_it_is_done():
    planner = PathPlanner(Task(cylinder(), 0.0, target()), SETTINGS)
    rig = Rig(plan=lambda: planner)
    while not (rig.segments and rig.segments[-1].last):
        rig.under_head = max(len(rig.segments) - 1, 0)
        rig.say()
        time.sleep(0.01)
    planner.cut_short = "joint 2 meets its limit"
    rig.say(done=True)
    outcome = rig.end()
    assert outcome.code == Code.NONE
    assert outcome.message == "the path ended after 100%, out of reach: joint 2 meets its limit"
    assert outcome.told("Trunk_skin").endswith(outcome.message)


def test_a_planner_that_was_itself_held_up_does_not_call_the_arm_silent():
    """All of the process stood still: what the arm said meanwhile is heard right afterwards."""
    settings = ScrubPlannerSettings(arm_state_max_age=0.3, stall_timeout=30.0)
    rig = Rig(settings)
    rig.wait(lambda: rig.segments)
    with rig.job._news:  # the job's thread cannot go on
        time.sleep(0.6)
    rig.job.join(0.02)
    assert rig.outcome is None
    rig.say()
    rig.job.cancel()
    assert rig.end().code == Code.CANCELED


def test_silent_arm_ends_the_job():
    outcome = Rig(ScrubPlannerSettings(arm_state_max_age=0.1)).end()
    assert outcome.code == Code.ARM_STOPPED
    assert "silent" in outcome.message


def test_arm_that_does_not_take_up_the_path_ends_the_job():
    rig = Rig(ScrubPlannerSettings(stall_timeout=0.2, arm_state_max_age=30.0))
    while rig.outcome is None:
        rig.job.see_arm(ArmReport(State.CONTACT, "", 3, 0, 0, 0.0, False))
        time.sleep(0.01)
    assert rig.end().code == Code.ARM_STOPPED
    assert "did not move on along path 7" in rig.outcome.message


def test_a_segment_that_the_arm_refuses_ends_the_job_at_once_with_the_arms_reason():
    """Nothing more is sent, and the arm must not use up what it took."""
    rig = Rig()
    rig.wait(lambda: len(rig.segments) == 3)
    rig.job.see_arm(ArmReport(State.CONTACT, refusal_of(8, 1, "of another path"), 7, 0, 3, 0.0, False))
    rig.job.join(0.2)
    assert rig.outcome is None
    rig.job.see_arm(ArmReport(State.CONTACT, refusal_of(7, 2, "18 mm too deep"), 7, 1, 1, 0.06, False))
    outcome = rig.end()
    assert outcome.code == Code.UNREACHABLE
    assert "path 7: segment 2 was refused: 18 mm too deep" in outcome.message
    assert outcome.broke_off
    assert len(rig.segments) == 3


def test_a_first_segment_that_is_refused_is_told_though_the_arm_is_on_no_path():
    rig = Rig()
    rig.wait(lambda: rig.segments)
    rig.job.see_arm(ArmReport(State.CONTACT, refusal_of(7, 0, "no way there"), 3, 0, 0, 0.0, False))
    assert "no way there" in rig.end().message


def test_large_shift_loses_the_target():
    rig = Rig()
    rig.wait(lambda: len(rig.segments) == 3)
    rig.job.see_surface(Sighting(1.0, lambda: plane(out=0.03)))
    rig.wait(lambda: rig.outcome is not None)
    assert rig.end().code == Code.TARGET_LOST


def test_unseen_skin_loses_the_target():
    rig = Rig()
    rig.wait(lambda: rig.segments)
    rig.now = 10.0
    rig.wait(lambda: rig.outcome is not None)
    assert rig.end().code == Code.TARGET_LOST
    assert "no skin around the arm was seen for 10.0 s" in rig.outcome.message


def test_path_that_cannot_be_planned_ends_the_job():
    def plan():
        raise SurfaceError("no skin")

    outcome = Rig(plan=plan).end()
    assert outcome == (Code.NO_SURFACE, "no skin", 0, 0.0)


def test_a_fault_in_planning_ends_the_job_too():
    def plan():
        raise ZeroDivisionError("by nought")

    outcome = Rig(plan=plan).end()
    assert outcome.code == Code.TARGET_LOST
    assert "ZeroDivisionError: by nought" in outcome.message


@pytest.mark.parametrize(("code", "segments", "pauses"), [
    (Code.TARGET_LOST, 4, True), (Code.UNREACHABLE, 1, True), (Code.CANCELED, 3, True),
    (Code.CANCELED, 0, False), (Code.NONE, 9, False), (Code.FORCE_LIMIT, 4, False),
    (Code.ARM_STOPPED, 4, False),
])  # fmt: skip
def test_the_arm_is_paused_where_it_would_scrub_on_alone(code, segments, pauses):
    assert Outcome(code, "", segments, 0.1).broke_off is pauses


def test_an_end_is_told_in_one_line():
    assert Outcome(Code.NONE, "", 7, 0.412).told("Foot_skin") == "scrubbed 0.41 m of Foot_skin in 7 segments"
    assert Outcome(Code.CANCELED, "canceled", 2, 0.1).told("Foot_skin") == "Foot_skin: canceled"
    assert Outcome(Code.CANCELED, "", 2, 0.1).harmless
    assert not Outcome(Code.TARGET_LOST, "", 2, 0.1).harmless


def test_what_refuses_a_scrub_is_its_outcome():
    assert refusal(NotReadyError("no arm_state yet")) == (Code.NOT_READY, "no arm_state yet", 0, 0.0)
