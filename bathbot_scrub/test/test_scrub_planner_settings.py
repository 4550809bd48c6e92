"""Settings of the planner and its YAML file."""

from dataclasses import asdict
from pathlib import Path

import pytest
import yaml
from bathbot_scrub.errors import SettingsError
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

CONFIG = Path(__file__).parents[1] / "config" / "scrub_planner.yaml"


def test_yaml_holds_the_defaults_of_all_fields():
    stored = yaml.safe_load(CONFIG.read_text())["/**/scrub_planner"]["ros__parameters"]
    assert stored == asdict(ScrubPlannerSettings())


@pytest.mark.parametrize(
    ("name", "value"),
    [("step", 0.0), ("compression", 0.011), ("segment_points", 2), ("min_reach", 1.5),
     ("speed", float("nan")), ("cell", 0.05), ("max_slope_deg", 90.0), ("ahead", 0)],
)  # fmt: skip
def test_senseless_values_are_refused_with_name_and_value(name, value):
    with pytest.raises(SettingsError, match=f"{name}.*{value}"):
        ScrubPlannerSettings(**{name: value})
