"""The limits file, and the filter that feeds the guard."""

import numpy as np
import pytest
import yaml
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_scrub.arm.collision_table import parts_of, quasi_static
from bathbot_scrub.arm.errors import ArmSettingsError
from bathbot_scrub.arm.force_limits import default_file, load_force_limits, shipped_force_limits
from bathbot_scrub.rm65.force.wrench_filter import WrenchFilter, at_tip
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

CLASSES = ["Face_skin", "Trunk_skin", "Upperlimb_skin", "Lowerlimb_skin", "Hand_skin", "Foot_skin"]
forces = st.tuples(*[st.floats(-20.0, 20.0)] * 3).map(np.array)


def test_every_class_has_limits_and_the_face_the_gentlest():
    limits = shipped_force_limits()
    assert list(limits.regions) == CLASSES
    assert limits.gentlest() is limits.region("Face_skin")
    assert limits.region("Trunk_skin").comfort == (1.0, 6.0)
    assert (limits.contact, limits.region("Trunk_skin").retract, limits.region("Trunk_skin").hard_stop) == (
        1.0,
        10.0,
        15.0,
    )


def test_every_number_of_the_file_is_read(tmp_path):
    content = yaml.safe_load(default_file().read_text())
    shipped, changed = load_force_limits(), tmp_path / "limits.yaml"
    for key in ("contact", "zero_residual", "transit", "surge", "give"):
        changed.write_text(yaml.safe_dump(content | {key: content[key] * 0.9}))
        assert getattr(load_force_limits(changed), key) == pytest.approx(content[key] * 0.9)
    for key, value in content["regions"]["Trunk_skin"].items():
        other = [0.99 * v for v in value] if isinstance(value, list) else 0.99 * value
        regions = content["regions"] | {"Trunk_skin": content["regions"]["Trunk_skin"] | {key: other}}
        changed.write_text(yaml.safe_dump(content | {"regions": regions}))
        assert_allclose(getattr(load_force_limits(changed).region("Trunk_skin"), key), other)
    assert shipped == load_force_limits()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        pytest.param(lambda c: c.pop("surge"), "lacks", id="missing"),
        pytest.param(lambda c: c.update(colour=1), "unknown", id="unknown"),
        pytest.param(lambda c: c.update(contact="one"), "finite number", id="text"),
        pytest.param(lambda c: c.update(contact=[1.0]), "one number", id="list"),
        pytest.param(lambda c: c.update(contact=float("nan")), "finite number", id="NaN"),
        pytest.param(lambda c: c.update(contact=20.0), "must lie below", id="contact above retract"),
        pytest.param(lambda c: c.update(zero_residual=2.0), "zero_residual < contact", id="residual"),
        pytest.param(lambda c: c.update(transit=0.1), "transit > zero_residual", id="transit"),
        pytest.param(lambda c: c.update(give=0.9), "lie below give", id="give"),
        pytest.param(lambda c: c["regions"]["Face_skin"].update(retract=20.0), "must rise", id="order"),
        pytest.param(lambda c: c["regions"]["Face_skin"].update(axis=[1.0, 2.0]), "axis three", id="axis"),
        pytest.param(
            lambda c: c["regions"]["Face_skin"].update(axis=[-1.0, 2.0, 2.0]), "positive", id="negative"
        ),
        pytest.param(lambda c: c["regions"].update(Hand_skin=3), "lacks", id="region is a number"),
        pytest.param(lambda c: c.update(regions={}), "table", id="no regions"),
    ],
)
def test_a_bad_file_is_one_line_with_its_name(tmp_path, change, told):
    content = yaml.safe_load(default_file().read_text())
    change(content)
    file = tmp_path / "limits.yaml"
    file.write_text(yaml.safe_dump(content))
    with pytest.raises(ArmSettingsError, match=told) as caught:
        load_force_limits(file)
    assert "limits.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def region(content, name="Trunk_skin", **changes):
    """A file's content with another entry for a region."""
    entry = content["regions"]["Trunk_skin"] | changes
    return content | {"regions": content["regions"] | {name: entry}}


BEYOND = {  # a bound passed, in a file that is in order else
    "threshold of 100 N": (
        lambda c: region(c, retract=100.0, hard_stop=120.0, collision=1000.0), r"Trunk_skin\.collision .* 110"
    ),
    "collision": (lambda c: region(c, collision=110.5), r"Trunk_skin\.collision .* 110, got 110\.5"),
    "hard_stop": (lambda c: region(c, hard_stop=25.5), r"Trunk_skin\.hard_stop .* 25, got 25\.5"),
    "hard_stop of a face": (
        lambda c: region(c, "Face_skin", retract=9.0, hard_stop=11.5, collision=65.0),
        r"Face_skin\.hard_stop .* 11",
    ),
    "collision of a class nobody knows": (lambda c: region(c, "Knee_skin"), r"Knee_skin\.collision .* 65"),
    "hard_stop of a class nobody knows": (
        lambda c: region(c, "Knee_skin", collision=65.0), r"Knee_skin\.hard_stop .* 11"
    ),
    "axis": (lambda c: region(c, axis=[6.0, 15.5, 10.0]), r"Trunk_skin\.axis .* 15"),
    "torque": (lambda c: region(c, torque=0.4), r"Trunk_skin\.torque .* 0\.375"),
    "contact": (lambda c: c | {"contact": 2.1}, "contact .* 2, got"),
    "zero_residual": (lambda c: c | {"contact": 1.9, "zero_residual": 1.1}, "zero_residual .* 1, got"),
    "transit": (lambda c: c | {"transit": 6.1}, "transit .* 6, got"),
    "surge": (lambda c: c | {"surge": 61.0}, "surge .* 60, got"),
    "give": (lambda c: c | {"give": 6.1}, "give .* 6, got"),
}  # fmt: skip


@pytest.mark.parametrize("beyond", BEYOND)
def test_no_file_passes_what_skin_bears(tmp_path, beyond):
    change, told = BEYOND[beyond]
    file = tmp_path / "limits.yaml"
    file.write_text(yaml.safe_dump(change(yaml.safe_load(default_file().read_text()))))
    with pytest.raises(ArmSettingsError, match=told) as caught:
        load_force_limits(file)
    assert "\n" not in str(caught.value)


def test_a_class_nobody_knows_may_be_touched_as_gently_as_a_face(tmp_path):
    content = yaml.safe_load(default_file().read_text())
    content["regions"]["Knee_skin"] = content["regions"]["Face_skin"]
    file = tmp_path / "limits.yaml"
    file.write_text(yaml.safe_dump(content))
    assert load_force_limits(file).region("Knee_skin").hard_stop == 8.0


def test_the_shipped_file_names_the_collision_table():
    for name, entry in shipped_force_limits().regions.items():
        assert entry.collision == quasi_static(name) == min(part.quasi_static for part in parts_of(name))
    assert quasi_static("Knee_skin") == quasi_static("Face_skin") == 65.0


@pytest.mark.parametrize("content", [b"a: [1", b"\xff\xfe", b"3"])
def test_no_yaml_is_one_line(tmp_path, content):
    file = tmp_path / "limits.yaml"
    file.write_bytes(content)
    with pytest.raises(ArmSettingsError, match=r"limits\.yaml") as caught:
        load_force_limits(file)
    assert "\n" not in str(caught.value)


def test_missing_file_and_unknown_region_say_what_to_try():
    with pytest.raises(ArmSettingsError, match="cannot read"):
        load_force_limits("/nowhere/limits.yaml")
    with pytest.raises(ArmSettingsError, match="known are Face_skin"):
        shipped_force_limits().region("Knee")


@given(force=forces, torque=forces)
def test_a_force_at_the_tip_has_no_torque_about_the_tip(force, torque):
    lever = np.array([0.0, 0.0, SCRUB_HEAD.length])
    flange = np.concatenate([force, np.cross(lever, force) + torque])
    assert_allclose(at_tip(flange), np.concatenate([force, torque]), atol=1e-12)


@given(force=forces)
def test_filter_keeps_a_constant_and_starts_with_it(force):
    wrench_filter = WrenchFilter(15.0)
    for k in range(30):
        wrench = wrench_filter.update(0.005 * k, [*force, 0.0, 0.0, 0.0])
        assert_allclose(wrench.filtered[:3], force, atol=1e-9)
    assert_allclose(wrench.sudden[:3], force, atol=1e-9)
    assert [trend.count for trend in wrench.trends] == [5, 9, 17]
    for trend in wrench.trends:
        assert trend.rise == pytest.approx(0.0, abs=1e-6)
        assert trend.force == pytest.approx(np.linalg.norm(force), abs=1e-9)


def test_a_step_is_passed_in_a_few_time_constants():
    wrench_filter = WrenchFilter(15.0)
    for k in range(10):
        wrench_filter.update(0.005 * k, np.zeros(6))
    wrench = [wrench_filter.update(0.05 + 0.005 * k, [50.0, 0, 0, 0, 0, 0]) for k in range(13)]
    assert (wrench[0].sudden[0], wrench[1].sudden[0]) == (0.0, 50.0)
    assert wrench[-1].force > 48.0


@given(glitch=st.tuples(*[st.floats(-1e4, 1e4)] * 6), noise=st.integers(0, 100))
def test_a_single_glitch_of_any_size_changes_the_filtered_by_noise_and_the_sudden_by_a_newton(glitch, noise):
    wrench_filter, samples = WrenchFilter(15.0), np.random.default_rng(noise).normal(0.0, 0.05, (20, 6))
    samples[10] = glitch
    for k, sample in enumerate(samples):
        wrench = wrench_filter.update(0.005 * k, sample)
        assert np.abs(wrench.filtered[:3]).max() < 0.3
        assert np.abs(wrench.sudden[:3]).max() < 1.3


def test_a_force_that_rises_steadily_is_sudden_at_once():
    wrench_filter = WrenchFilter(15.0)
    for k in range(40):
        wrench = wrench_filter.update(0.005 * k, [0, 0, -0.5 * k, 0, 0, 0])
        assert wrench.sudden[2] == pytest.approx(-0.5 * k)


@pytest.mark.parametrize("part", range(6))
def test_a_wrench_of_which_one_part_is_no_number_goes_into_no_filter(part):
    wrench_filter, broken = WrenchFilter(15.0), np.ones(6)
    broken[part] = np.nan
    wrench_filter.update(0.0, np.ones(6))
    assert not np.isfinite(wrench_filter.update(0.005, broken).filtered).all()
    assert wrench_filter.update(0.005, broken).trends == ()
    assert_allclose(wrench_filter.update(0.01, np.full(6, 2.0)).filtered[:3], 2.0)


def test_a_wrench_that_is_no_number_is_told_and_forgotten():
    wrench_filter = WrenchFilter(15.0)
    wrench_filter.update(0.0, np.ones(6))
    assert np.isnan(wrench_filter.update(0.005, np.full(6, np.nan)).filtered).all()
    assert_allclose(wrench_filter.update(0.01, np.full(6, 2.0)).filtered[:3], 2.0)


@given(slope=st.floats(1.0, 190.0))
def test_trends_are_the_slope_and_the_force_now(slope):
    """Up to 190 N/s, at which a sample differs by less than a newton from the one before."""
    wrench_filter = WrenchFilter(15.0)
    for k in range(20):
        wrench = wrench_filter.update(0.005 * k, [0, 0, -slope * 0.005 * k, 0, 0, 0])
        assert [trend.count for trend in wrench.trends] == [n for n in (5, 9, 17) if n <= k + 1]
    for trend in wrench.trends:
        assert trend.rise == pytest.approx(slope)
        assert trend.force == pytest.approx(slope * 0.005 * 19)
        assert trend.span == pytest.approx(0.005 * (trend.count - 1))


@given(glitch=st.tuples(*[st.one_of(st.floats(1.1, 1e4), st.floats(-1e4, -1.1))] * 3))
def test_a_single_glitch_of_any_size_is_no_rise(glitch):
    wrench_filter = WrenchFilter(15.0)
    for k in range(40):
        wrench = wrench_filter.update(0.005 * k, [*(glitch if k == 20 else (0.0, 0.0, 0.0)), 0, 0, 0])
        assert all(abs(trend.rise) < 1e-9 for trend in wrench.trends)


def test_samples_that_arrive_together_were_not_taken_together():
    wrench_filter = WrenchFilter(15.0)
    for k in range(20):
        wrench = wrench_filter.update(1e-5 * k, [0, 0, -5.0 - 0.05 * k, 0, 0, 0])
    assert all(0.0 < trend.rise < 15.0 for trend in wrench.trends)
