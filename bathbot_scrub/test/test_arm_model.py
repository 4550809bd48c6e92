"""The URDF and the Pinocchio model made from it, against our own kinematics and plain geometry."""

import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from bathbot_depthcorr.geometry.rigid import transform_points
from bathbot_scrub.arm.errors import ArmSettingsError
from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS, JOINT_NAMES, LINK_NAMES
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.arm.urdf import urdf
from bathbot_scrub.rm65.arm.walls import Wall, walls_from
from bathbot_scrub.rm65.paths.self_collision import ArmModel
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

JOINTS = np.random.default_rng(2).uniform(RM65_LIMITS.lower, RM65_LIMITS.upper, (60, 6))
MODEL, ARM = ArmModel(RM65("6F")), RM65("6F")


@pytest.mark.parametrize("variant", FLANGE_OFFSETS)
def test_links_are_where_pinocchio_puts_those_of_the_urdf(variant):
    model, arm = pin.buildModelFromXML(urdf(variant)), RM65(variant)
    data = model.createData()
    for joints in JOINTS:
        pin.framesForwardKinematics(model, data, joints)
        frames = np.stack(
            [data.oMf[model.getFrameId(name)].homogeneous for name in (*LINK_NAMES, ARM.tool.frame)]
        )
        assert_allclose(frames[:7], arm.link_frames(joints), atol=1e-9)
        assert_allclose(frames[7], arm.head(joints), atol=1e-9)


def test_the_urdf_holds_the_limits_and_masses_of_the_data_sheet():
    model = pin.buildModelFromXML(urdf("6F"))
    assert list(model.names)[1:] == list(JOINT_NAMES)
    assert_allclose(model.lowerPositionLimit, RM65_LIMITS.lower, atol=1e-8)
    assert_allclose(model.upperPositionLimit, RM65_LIMITS.upper, atol=1e-8)
    assert_allclose(model.velocityLimit, RM65_LIMITS.speed, atol=1e-8)
    masses = [inertia.mass for inertia in model.inertias]
    assert_allclose(masses[1:6], [1.51, 1.653, 0.726, 0.671, 0.647])
    assert masses[6] == pytest.approx(0.248 + 0.35)  # flange with its head
    for inertia in list(model.inertias)[1:]:
        moments = np.linalg.eigvalsh(inertia.inertia)
        assert moments[0] > 0.0
        assert moments[2] <= moments[0] + moments[1] + 1e-12  # of a body that can exist


def test_every_link_has_its_capsules():
    root = ElementTree.fromstring(urdf("6FB"))
    shapes = {link.get("name"): len(link.findall("collision")) for link in root.findall("link")}
    capsules = RM65("6FB").shape.capsules
    assert shapes == {
        name: 3 * sum(c.link == name for c in capsules) for name in (*LINK_NAMES, ARM.tool.frame)
    }


def test_a_shorter_flange_has_a_shorter_last_link():
    lengths = {
        v: next(c.end[2] - c.start[2] for c in RM65(v).shape.capsules if c.link == "Link6")
        for v in FLANGE_OFFSETS
    }
    assert lengths["6F"] - lengths["B"] == pytest.approx(FLANGE_OFFSETS["6F"] - FLANGE_OFFSETS["B"])


@pytest.mark.graph
def test_the_command_prints_it_and_refuses_an_unknown_variant():
    run = lambda *words: subprocess.run(  # noqa: E731
        [sys.executable, "-m", "bathbot_scrub.rm65.arm.urdf", *words],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run("B").stdout == urdf("B")
    refused = run("7F")
    assert refused.returncode == 2
    assert "known are B, 6F, 6FB" in refused.stderr
    with pytest.raises(ArmSettingsError):
        urdf("7F")


def test_the_jacobian_is_ours():
    for joints in JOINTS:
        assert_allclose(MODEL.jacobian(joints), ARM.jacobian(joints), atol=1e-9)
        assert_allclose(MODEL.head(joints), ARM.head(joints), atol=1e-9)


def test_manipulability_is_none_in_singular_postures_and_does_not_change_about_joint_1():
    begin = np.array([0.1, -0.9, -1.2, 0.3, 0.9, 0.5])
    assert MODEL.manipulability(begin) > 1e-3
    assert MODEL.manipulability(begin + 0.8 * np.eye(6)[0]) == pytest.approx(MODEL.manipulability(begin))
    for joint in (2, 4):
        assert MODEL.manipulability(np.where(np.arange(6) == joint, 0.0, begin)) < 1e-9


def sampled_distance(first, second, joints, count=300):
    """Distance of two capsules' surfaces by points along their axes."""
    frames = dict(zip(LINK_NAMES, ARM.link_frames(joints), strict=True)) | {ARM.tool.frame: ARM.head(joints)}
    share = np.linspace(0.0, 1.0, count)[:, None]
    axes = [
        transform_points(frames[c.link], np.array(c.start) + share * (np.array(c.end) - c.start))
        for c in (first, second)
    ]
    apart = np.linalg.norm(axes[0][:, None] - axes[1][None], axis=-1).min()
    return apart - first.radius - second.radius


def test_the_nearest_pair_is_that_of_plain_geometry():
    capsules = ARM.shape.capsules
    chain = (*LINK_NAMES, ARM.tool.frame)
    for joints in JOINTS[:12]:
        expected = min(
            sampled_distance(first, second, joints)
            for i, first in enumerate(capsules)
            for second in capsules[i + 1 :]
            if chain.index(second.link) - chain.index(first.link) > 2
        )
        assert MODEL.nearest(joints).distance == pytest.approx(expected, abs=1e-3)


def test_a_mirrored_posture_is_as_near_to_itself():
    mirror = np.array([-1.0, 1.0, 1.0, -1.0, 1.0, -1.0])  # in the plane y = 0
    for joints in JOINTS[:20]:
        assert MODEL.nearest(mirror * joints).distance == pytest.approx(MODEL.nearest(joints).distance)


@given(
    joints=st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6).map(np.array),
    tilt=st.floats(-0.5, 0.5),
    away=st.floats(0.0, 0.6),
)
@settings(max_examples=30, deadline=None)
def test_a_wall_is_as_far_as_the_end_of_a_capsule_next_to_it(joints, tilt, away):
    wall = Wall((float(np.sin(tilt)), 0.0, float(np.cos(tilt))), -away)
    frames = dict(zip(LINK_NAMES, ARM.link_frames(joints), strict=True)) | {ARM.tool.frame: ARM.head(joints)}
    to_wall = min(
        float((transform_points(frames[c.link], [c.start, c.end]) @ wall.normal).min()) - c.radius + away
        for c in ARM.shape.capsules
        if c.link not in ("base_link", "Link1")
    )
    near = ArmModel(ARM, [wall]).nearest(joints)
    assert near.distance == pytest.approx(min(to_wall, MODEL.nearest(joints).distance), abs=1e-6)
    if to_wall < MODEL.nearest(joints).distance - 1e-6:
        assert near.second == wall.name


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ([1.0, 0.0, 0.0], "four finite numbers"),
        ([0.0, 0.0, 0.0, -1.0], "not zero"),
        ([1.0, 0.0, 0.0, np.nan], "four finite numbers"),
        ([1.0, 0.0, 0.0, 0.5], "turn it round"),
    ],
)
def test_walls_that_are_none_are_refused(numbers, message):
    with pytest.raises(ArmSettingsError, match=message):
        walls_from(numbers)


@pytest.mark.graph
def test_a_light_command_does_not_load_pinocchio():
    code = (
        "import sys, bathbot_scrub.path.reach, bathbot_scrub.rm65.paths.motion_planner;"
        "assert 'pinocchio' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
