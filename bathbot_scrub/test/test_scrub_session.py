"""One scrub at a time, and who is told what of it, in which order."""

import threading
import time

import pytest
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import NotReadyError
from bathbot_scrub.job.scrub_job import ArmReport, Code
from bathbot_scrub.job.scrub_session import Listeners, ScrubSession
from bathbot_scrub.path.surface_map import Sighting
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from scipy.spatial.transform import Rotation
from synthetic_skin import DISTANCE, cylinder, moved, target

ARM, REGION, NOW = RM65("6F"), "Trunk_skin", 100.0
SETTINGS = ScrubPlannerSettings(arm_state_max_age=30.0, stall_timeout=30.0)  # the tests may be slow
# the cylinder of the other tests, carried to where the arm reaches it
TURN = Rotation.from_euler("z", 40, degrees=True).as_matrix()
MOVE = transform_from(TURN, (0.5, 0.0, 0.3)) @ transform_from(translation=(-DISTANCE, 0.0, 0.0))
TARGET = MOVE @ target()
JOINTS = nearest(ARM.solve_head(TARGET), ARM.home, ARM.limits)


class Rig:
    """A session that has seen skin and target, with an arm in contact that takes segments and stands."""

    def __init__(self):
        self.session = ScrubSession(ARM, shipped_force_limits(), SETTINGS, lambda: NOW)
        self.told, self.ended = [], threading.Event()
        for _ in range(2):
            self.session.see_arm(ArmReport(State.FREE, "", 0, 0, 0, 0.0, False))
            self.session.see_surface(Sighting(NOW - 1.0, lambda: moved(MOVE, cylinder())))
            self.session.inputs.before.see_targets({REGION: TARGET}, NOW - 1.0)
        self.session.see_arm(ArmReport(State.CONTACT, "", 0, 0, 0, 0.0, False))
        self.session.inputs.see_head(lambda: TARGET)
        self.session.inputs.see_joints(lambda: JOINTS)

    def begin(self):
        self.session.begin(REGION, 0.0, Listeners(
            lambda task: self.told.append("begun"), lambda task, planner: self.told.append("chosen"),
            lambda segment, seconds, fraction: self.told.append((segment.index, fraction)),
            lambda: self.told.append("broke off"), self.end,
        ))  # fmt: skip

    def end(self, outcome):
        self.told.append(outcome.code)
        self.ended.set()

    def sent(self):
        return [told[0] for told in self.told if isinstance(told, tuple)]


@pytest.fixture
def rig():
    rig = Rig()
    yield rig
    rig.session.close()


def until(condition):
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_a_scrub_is_told_from_its_begin_to_its_end(rig):
    rig.begin()
    until(lambda: len(rig.sent()) == 3)
    rig.session.cancel()
    assert rig.ended.wait(20.0)
    assert rig.told[:2] == ["begun", "chosen"]
    assert rig.sent() == [0, 1, 2]
    fractions = [told[1] for told in rig.told if isinstance(told, tuple)]
    assert 0.0 < fractions[0] < fractions[1] < fractions[2] < 1.0
    assert rig.told[-2:] == ["broke off", Code.CANCELED]  # paused before another may begin


def test_while_one_is_on_its_way_another_is_refused_and_afterwards_taken(rig):
    rig.begin()
    with pytest.raises(NotReadyError, match="another path is being scrubbed"):
        rig.begin()
    rig.session.cancel()
    assert rig.ended.wait(20.0)
    rig.begin()
    assert rig.told.count("begun") == 2


def test_an_arm_that_leaves_ends_it_without_a_pause(rig):
    rig.begin()
    until(rig.sent)
    rig.session.see_arm(ArmReport(State.RETRACTING, "too much force", 0, 0, 0, 0.0, False))
    assert rig.ended.wait(20.0)
    assert rig.told[-1] is Code.FORCE_LIMIT
    assert "broke off" not in rig.told


def test_skin_that_moves_while_it_is_scrubbed_loses_the_target(rig):
    rig.begin()
    until(rig.sent)
    away = cylinder()
    away[..., 0] -= 0.03
    rig.session.see_surface(Sighting(NOW + 1.0, lambda: moved(MOVE, away)))
    assert rig.ended.wait(20.0)
    assert rig.told[-2:] == ["broke off", Code.TARGET_LOST]


def test_closing_ends_what_is_on_its_way(rig):
    rig.begin()
    rig.session.close()
    assert rig.ended.is_set()
