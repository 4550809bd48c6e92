"""What is remembered from before the arm came."""

import numpy as np
import pytest
from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import NotReadyError, SurfaceError
from bathbot_scrub.job.before_contact import BeforeContact
from bathbot_scrub.job.scrub_job import ArmReport
from bathbot_scrub.path.surface_map import Sighting

TARGET = np.eye(4)


def said(mode):
    return ArmReport(mode, "", 0, 0, 0, 0.0, False)


def remembered(*events):
    memory = BeforeContact(10.0, 6.0)
    for event in events:
        if isinstance(event, State):
            memory.see_arm(said(event))
        elif isinstance(event, Sighting):
            memory.see_surface(event)
        else:
            memory.see_targets({"Trunk_skin": TARGET}, event)
    return memory


ANCIENT = Sighting(-9.0, lambda: np.zeros((1, 1, 3)))
OLD, NEW = Sighting(1.0, lambda: np.zeros((1, 1, 3))), Sighting(2.0, lambda: np.ones((1, 1, 3)))


def test_surface_from_the_time_the_arm_was_free_counts():
    seen_free = (State.FREE, OLD, 1.0, State.FREE, NEW)
    memory = remembered(*seen_free, State.APPROACH, NEW, State.CONTACT, NEW)
    sighting, target = memory.recall("Trunk_skin", 5.0)
    assert sighting is OLD
    assert target is TARGET


@pytest.mark.parametrize(
    ("events", "error", "words"),
    [
        ((), NotReadyError, "no arm_state yet"),
        ((State.FREE, OLD, 1.0), NotReadyError, "FREE, not in CONTACT"),
        ((State.FREE, OLD, State.FREE, State.CONTACT), SurfaceError, "no contact target of region"),
        ((State.FREE, 1.0, State.FREE, State.CONTACT), SurfaceError, "no surface was seen"),
        ((State.FREE, ANCIENT, 1.0, State.FREE, State.CONTACT), SurfaceError, "surface .* is 14 s old"),
        ((State.FREE, OLD, -9.0, State.FREE, State.CONTACT), SurfaceError, "target .* is 14 s old"),
    ],
)
def test_what_is_missing_is_named(events, error, words):
    with pytest.raises(error, match=words):
        remembered(*events).recall("Trunk_skin", 5.0)


def test_surfaces_of_the_last_breaths_are_kept_sparsely():
    memory = BeforeContact(10.0, 6.0)
    for index in range(101):
        memory.see_surface(Sighting(0.1 * index, OLD.decode))
    stamps = np.array([sighting.stamp for sighting in memory.recent])
    assert stamps[0] >= 10.0 - 6.0 - 1e-9
    assert stamps[-1] >= 9.8
    assert np.diff(stamps).min() > 0.15
    assert len(stamps) == pytest.approx(30, abs=2)
