"""Keys of SROS2: who may do what, judged by the XML; whether they hold, judged by OpenSSL."""

import re
import shutil
import subprocess
from datetime import UTC, datetime, timedelta
from fnmatch import fnmatchcase
from pathlib import Path
from xml.etree import ElementTree

import pytest
from bathbot_bringup.bag.recording.privacy import find_profile
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import InputError, SettingsError
from bathbot_bringup.graph.keys import rights
from bathbot_bringup.graph.keys.keystore import make_keystore
from bathbot_depthcorr.errors import SettingsError as ReachError
from bathbot_depthcorr.node.dds import enclave, reach
from hypothesis import given
from hypothesis import strategies as st

PROFILE = find_profile(Path(__file__).parents[1] / "config" / "privacy_profiles.yaml", "metrics_only")
SHOWN = [entry.pattern for entry in PROFILE.entries]
ROBOT, WATCHER = rights.robot(), rights.watcher(SHOWN)
NOW = datetime.now(UTC)
NAMES = st.lists(
    st.sampled_from(["arm", "wrench", "camera", "surface", "tf", "arm_state", "stop", "watcher", "_action"])
    | st.text("abcdefghijklmnopqrstuvwxyz_0", min_size=1, max_size=8),
    min_size=1,
    max_size=4,
).map(lambda words: "/" + "/".join(words))


def granted(who):
    """Read permissions as DDS does: the verb and topic are allowed by a rule, or refused."""
    grant = ElementTree.fromstring(rights.permissions(who, [7], NOW, NOW)).find("permissions/grant")
    assert [child.tag for child in grant] == ["subject_name", "validity", "allow_rule", "default"]
    assert grant.findtext("default") == "DENY"
    rules = {
        verb: [topic.text for topic in grant.findall(f"allow_rule/{verb}/topics/topic")]
        for verb in ("publish", "subscribe")
    }
    return lambda verb, topic: any(fnmatchcase(topic, pattern) for pattern in rules[verb])


ROBOT_MAY, WATCHER_MAY = granted(ROBOT), granted(WATCHER)


@given(NAMES)
def test_a_watcher_hears_what_metrics_only_records_and_nothing_else(name):
    recorded = any(fnmatchcase(name, pattern) for pattern in SHOWN)
    assert WATCHER_MAY("subscribe", f"rt{name}") == recorded


@given(NAMES)
def test_a_watcher_calls_nothing_and_says_nothing_but_what_every_node_says(name):
    assert not WATCHER_MAY("publish", f"rq{name}Request")
    assert not WATCHER_MAY("subscribe", f"rr{name}Reply")
    assert WATCHER_MAY("publish", f"rt{name}") == (name in ("/rosout", "/parameter_events"))
    serves = name.startswith(("/watcher/", "/_ros2cli_"))
    assert WATCHER_MAY("publish", f"rr{name}Reply") == serves
    assert WATCHER_MAY("subscribe", f"rq{name}Request") == serves


@given(NAMES)
def test_the_robot_may_do_whatever_ros_can(name):
    for verb in ("publish", "subscribe"):
        assert all(ROBOT_MAY(verb, topic) for topic in (f"rt{name}", f"rq{name}Request", f"rr{name}Reply"))
        assert not ROBOT_MAY(verb, "DCPSTopic")


@pytest.mark.parametrize("topic", [
    "camera/camera/color/image_raw", "camera/camera/depth/image_rect_raw", "depth/corrected/image", "surface",
    "body_cloud", "arm/approach/_action/feedback", "parameter_events",
])  # fmt: skip
def test_nothing_that_shows_a_person_is_shown_to_a_watcher(topic):
    assert not WATCHER_MAY("subscribe", f"rt/{topic}")
    assert not WATCHER_MAY("subscribe", f"rt/left/{topic}")


def test_both_take_part_in_what_ros_says_of_its_nodes():
    assert all(may(verb, "ros_discovery_info") for may in (ROBOT_MAY, WATCHER_MAY)
               for verb in ("publish", "subscribe"))  # fmt: skip


def test_everything_is_encrypted_and_nobody_comes_in_without_a_key():
    rule = ElementTree.fromstring(rights.governance([7, 9])).find("domain_access_rules/domain_rule")
    assert [one.text for one in rule.findall("domains/id")] == ["7", "9"]
    topics = rule.findall("topic_access_rules/topic_rule")
    assert [topic.findtext("topic_expression") for topic in topics] == ["*"]
    said = {one.tag: one.text for parent in (rule, *topics) for one in parent if one.text.strip()}
    assert said.pop("allow_unauthenticated_participants") == "false"
    assert said.pop("topic_expression") == "*"
    kinds = {tag: text for tag, text in said.items() if tag.endswith("_kind")}
    assert kinds.keys() == {
        f"{what}_protection_kind" for what in ("discovery", "liveliness", "rtps", "metadata", "data")
    }
    assert set(kinds.values()) == {"ENCRYPT"}
    assert {text for tag, text in said.items() if tag not in kinds} == {"true"}
    assert "enable_join_access_control" in said


def make(folder, now=NOW, days=30):
    return make_keystore(folder, (ROBOT, WATCHER), [7], days, now).folder


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return make(tmp_path_factory.mktemp("keys") / "keystore")


def test_the_layout_is_that_of_sros2_and_closed_to_others(store):
    shared = {"identity_ca.cert.pem", "permissions_ca.cert.pem", "governance.p7s"}
    own = {"cert.pem", "key.pem", "permissions.xml", "permissions.p7s"}
    paths = {str(path.relative_to(store)): path for path in store.rglob("*") if not path.is_dir()}
    assert set(paths) == {
        "public/ca.cert.pem", "public/identity_ca.cert.pem", "public/permissions_ca.cert.pem",
        "private/ca.key.pem", "private/identity_ca.key.pem", "private/permissions_ca.key.pem",
        "enclaves/governance.xml", "enclaves/governance.p7s",
        *(f"enclaves/bathbot/{who}/{name}" for who in ("robot", "watcher") for name in shared | own),
    }  # fmt: skip
    for name, path in paths.items():
        if path.is_symlink():
            assert not path.readlink().is_absolute(), "a copy on another machine would lack it"
        assert path.stat().st_mode & 0o777 == 0o600, name
    assert {one.stat().st_mode & 0o777 for one in (store, *store.rglob("*")) if one.is_dir()} == {0o700}


def judged_by_openssl(test):
    """It asks a program, so it is a test of the graph."""
    there = shutil.which("openssl")
    return pytest.mark.graph(
        pytest.mark.skipif(there is None, reason="the judge, openssl, is not here")(test)
    )


def openssl(*words):
    return subprocess.run(["openssl", *map(str, words)], capture_output=True, text=True, check=False)


@judged_by_openssl
@pytest.mark.parametrize("who", ["robot", "watcher"])
def test_openssl_verifies_certificates_and_their_dates(store, who):
    authority, certificate = store / "public/ca.cert.pem", store / f"enclaves/bathbot/{who}/cert.pem"
    assert openssl("verify", "-CAfile", authority, certificate).returncode == 0
    told = openssl("x509", "-in", certificate, "-noout", "-subject", "-enddate", "-text").stdout
    assert f"CN = /bathbot/{who}" in told
    assert "prime256v1" in told
    assert f"notAfter={NOW + timedelta(days=30):%b %e %H:%M:%S %Y} GMT" in told
    assert openssl("verify", "-CAfile", certificate, certificate).returncode != 0


@judged_by_openssl
@pytest.mark.parametrize("name", ["governance", "bathbot/robot/permissions", "bathbot/watcher/permissions"])
def test_openssl_verifies_what_was_signed_and_refuses_a_changed_letter(store, tmp_path, name):
    signed, authority = store / f"enclaves/{name}.p7s", store / "public/ca.cert.pem"
    for program in ("smime", "cms"):
        told = openssl(program, "-verify", "-text", "-in", signed, "-CAfile", authority)
        assert told.returncode == 0, told.stderr
        assert told.stdout.split() == signed.with_suffix(".xml").read_text().split()
    changed = tmp_path / "changed.p7s"
    changed.write_bytes(signed.read_bytes().replace(b"<id>7<", b"<id>8<"))
    assert openssl("smime", "-verify", "-text", "-in", changed, "-CAfile", authority).returncode != 0


@judged_by_openssl
def test_a_watcher_cannot_sign_rights_for_himself(store, tmp_path):
    home, forged = store / "enclaves/bathbot/watcher", tmp_path / "forged.p7s"
    signing = ("-signer", home / "cert.pem", "-inkey", home / "key.pem")
    assert openssl("smime", "-sign", "-text", "-in", home / "permissions.xml", *signing, "-out", forged)
    judged = openssl("smime", "-verify", "-text", "-in", forged, "-CAfile", store / "public/ca.cert.pem")
    assert judged.returncode != 0
    assert "unsuitable certificate purpose" in judged.stderr


def test_two_keystores_share_no_key(store, tmp_path):
    other = make(tmp_path / "other")
    for name in ("private/ca.key.pem", "enclaves/bathbot/robot/key.pem", "enclaves/bathbot/watcher/key.pem"):
        assert (store / name).read_bytes() != (other / name).read_bytes()
    names = [path for one in (store, other) for path in one.rglob("*key.pem") if not path.is_symlink()]
    assert len({path.read_bytes() for path in names}) == len(names) == 6


def test_what_is_there_is_left_as_it_is(store, tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    for taken in (store, tmp_path, tmp_path / "file", tmp_path / "link"):
        before = sorted(taken.parent.rglob("*"))
        with pytest.raises(InputError, match="there already"):
            make(taken)
        assert sorted(taken.parent.rglob("*")) == before
    (tmp_path / "empty").mkdir(mode=0o755)
    assert (make(tmp_path / "empty") / "public").is_dir()


def test_half_a_keystore_is_none(tmp_path):
    with pytest.raises(FileExistsError):
        make_keystore(tmp_path / "keys", (ROBOT, ROBOT), [0], 30)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("domains", "days"), [([], 30), ([233], 30), ([-1], 30), ([0], 0), ([0], 3651)])
def test_domains_and_days_that_are_none_are_refused(tmp_path, domains, days):
    with pytest.raises(SettingsError, match="got"):
        make_keystore(tmp_path / "keys", (ROBOT,), domains, days)
    assert list(tmp_path.iterdir()) == []


def test_a_reach_over_the_network_takes_what_the_command_tells_to_export(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "9")
    assert run(["keys", str(tmp_path / "my keys"), "--days", "2"]) == 0
    told = capsys.readouterr().out
    exported = dict(re.findall(r"^  export (\w+)='?(.*?)'?$", told, re.MULTILINE))
    assert exported.pop("ROS_DOMAIN_ID") == "9"
    assert exported == reach.network_variables(tmp_path / "my keys", ROBOT.name)
    for name in (ROBOT.name, WATCHER.name):
        for other in ({}, {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}):
            assert reach.chosen(exported | {reach.ENCLAVE: name} | other) is reach.Reach.NETWORK
        assert f"enclaves{name}" in told
    assert f"{datetime.now(UTC) + timedelta(days=2):%Y-%m-%d}" in told
    assert f"Never copy {tmp_path}/my keys/private" in told
    with pytest.raises(ReachError, match=r"the enclave '/' of .* lacks identity_ca.cert.pem.*/bathbot/robot"):
        reach.chosen({name: value for name, value in exported.items() if name != reach.ENCLAVE})


@pytest.mark.parametrize("who", [ROBOT.name, WATCHER.name])
def test_what_is_copied_to_a_machine_is_enough_there_and_holds_nobody_elses_key(store, tmp_path, who):
    for part in ("public", f"enclaves{who}"):
        shutil.copytree(store / part, tmp_path / part, symlinks=True)
    shutil.copy(store / "enclaves/governance.p7s", tmp_path / "enclaves")
    assert enclave.trouble(tmp_path, who) == ""
    assert [path.parent.name for path in tmp_path.rglob("*key.pem")] == [who.rpartition("/")[2]]


@pytest.mark.parametrize(
    ("age", "said"), [(31, "certificate has expired"), (-3, "certificate is not yet valid")]
)
def test_keys_that_have_ended_or_not_begun_are_refused(tmp_path, age, said):
    old = make(tmp_path / "old", NOW - timedelta(days=age))
    assert enclave.trouble(old, ROBOT.name) == f"cert.pem: {said}"


def test_keys_that_do_not_belong_together_are_refused(store, tmp_path):
    other = make(tmp_path / "other")
    home = other / "enclaves/bathbot/robot"
    shutil.copy(store / "enclaves/bathbot/robot/key.pem", home)
    assert "do not fit together" in enclave.trouble(other, ROBOT.name)
    shutil.copy(store / "enclaves/bathbot/robot/cert.pem", home)
    assert enclave.trouble(other, ROBOT.name).startswith(
        "cert.pem: "
    )  # another authority's, of the same name
    (home / "key.pem").write_text("no key")
    assert "do not fit together" in enclave.trouble(other, ROBOT.name)
