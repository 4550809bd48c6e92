"""The regions of skin are the detector's in every table of numbers about them, whichever package holds it."""

from bathbot_bringup.sim.body import Part
from bathbot_bringup.sim.brush import SKIN_STIFFNESS
from bathbot_localize.target_localizer_settings import TargetLocalizerSettings
from bathbot_perception.classes import LABELS, SKIN_CLASSES
from bathbot_scrub.arm.force_limits import shipped_force_limits


def test_all_tables_have_the_detectors_regions():
    tables = {
        "select_region": TargetLocalizerSettings().region_names,
        "force limits": shipped_force_limits().regions,
        "simulated skin": SKIN_STIFFNESS,
    }
    assert {name: set(table) ^ set(SKIN_CLASSES) for name, table in tables.items()} == {
        name: set() for name in tables
    }


def test_simulated_bodies_are_labelled_in_the_detectors_order():
    names = [label.removesuffix("_skin").upper() for label in LABELS[:-1]]
    assert [part.name.replace("_", "") for part in Part][:-1] == names
