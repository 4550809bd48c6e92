"""How far the graph reaches: what the environment may ask for, whose ports are believed, what is filtered."""

import fcntl
import mmap
import os

import pytest
from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.node.dds import reach, shared_memory, socket_filter, transport, udp_ports
from bathbot_depthcorr.node.dds.reach import Reach
from bathbot_depthcorr.node.dds.shared_memory import ForeignMemoryError
from bathbot_depthcorr.node.dds.udp_ports import ANY, LOOPBACK, Port
from hypothesis import given
from hypothesis import strategies as st

ME, STRANGER = 1000, 1001
LOOPBACK_NUMBER = 0x7F000001
TABLE = """\
   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode
 4211: 0100007F:1CF2 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 979609 2
 5210: 00000000:9FA9 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 979611 2
"""
ALL_V6 = f"{0:032}"
TABLE_V6 = f"""\
  sl  local_address remote_address st tx_queue:rx_queue tr:tm->when retrnsmt uid timeout inode
   1: {ALL_V6}:0016 {ALL_V6}:0000 07 00000000:00000000 00:00000000 00000000  1001        0 77 2
"""


@pytest.fixture
def keys(tmp_path):
    return {
        reach.VARIABLE: "network",
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_KEYSTORE": str(tmp_path),
    }


def test_only_one_word_widens_the_reach():
    assert reach.chosen({}) is Reach.USER
    assert reach.chosen({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}) is Reach.USER
    assert reach.chosen({reach.VARIABLE: "machine"}) is Reach.MACHINE
    with pytest.raises(SettingsError, match="'lan'; user hears"):
        reach.chosen({reach.VARIABLE: "lan"})


def test_a_wider_reach_is_told_with_what_it_opens():
    assert "every user of this machine: pictures" in reach.seen_by(Reach.MACHINE)
    assert all(reach.seen_by(one) for one in Reach)


def test_the_network_asks_for_keys(keys):
    with pytest.raises(SettingsError, match=r"the enclave '/' of .* lacks identity_ca.cert.pem"):
        reach.chosen(keys)
    for name in set(keys) - {reach.VARIABLE}:
        for wrong in ({}, {name: "no"}):
            with pytest.raises(SettingsError, match=f"shows pictures of the person.*{name}="):
                reach.chosen({key: value for key, value in keys.items() if key != name} | wrong)


def test_other_middleware_is_refused_where_it_would_not_keep_to_this_machine():
    other = {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
    for word in ("user", "machine"):
        with pytest.raises(SettingsError, match="rmw_cyclonedds_cpp"):
            reach.chosen({reach.VARIABLE: word} | other)


def test_ros_variables_count_for_the_reach_network_only(monkeypatch):
    said = {transport.RANGE: "SUBNET", transport.PROFILES: "mine.xml", "ROS_STATIC_PEERS": "192.0.2.1"}
    for name, value in said.items():
        monkeypatch.setenv(name, value)
    chosen = transport.variables()
    assert chosen[transport.RANGE] == "SYSTEM_DEFAULT"
    assert chosen[transport.PROFILES] == transport.PICTURES
    assert chosen["ROS_STATIC_PEERS"] == ""
    monkeypatch.setenv(reach.VARIABLE, "network")
    assert not said.keys() & transport.variables().keys()


def test_the_kernels_table_is_read():
    assert udp_ports.parse(TABLE) == [
        Port(LOOPBACK, 0x1CF2, 1000, 979609),
        Port(ANY, 0x9FA9, 0, 979611),
    ]
    assert udp_ports.parse(TABLE_V6) == [Port(ANY, 22, 1001, 77)]


PORTS = st.lists(
    st.builds(
        Port,
        st.sampled_from([LOOPBACK, ANY, "c0000202"]),
        st.integers(1, 8),
        st.sampled_from([0, ME, STRANGER]),
        st.just(1),
    )
)


@given(PORTS)
def test_a_port_is_trusted_when_those_who_can_send_from_it_over_loopback_are(ports):
    found = udp_ports.trusted(ports, (0, ME))
    for number in range(1, 9):
        owners = {port.owner for port in ports if port.number == number and port.address != "c0000202"}
        assert (number in found) == (bool(owners) and STRANGER not in owners)


def passes(program, address, port):
    """Run classic BPF as the kernel does."""
    at = value = 0
    while True:
        code, if_true, if_false, operand = program[at]
        at += 1
        if code == 0x20:
            assert operand == (-0x100000 + 12) & 0xFFFFFFFF
            value = address
        elif code == 0x28:
            assert operand == 0
            value = port
        elif code == 0x15:
            assert max(if_true, if_false) <= 255
            at += if_true if value == operand else if_false
        elif code == 0x05:
            at += operand
        else:
            return bool(operand)


@given(st.sets(st.integers(1, 65535), max_size=700), st.integers(1, 65535))
def test_the_filter_lets_pass_these_ports_of_loopback_and_no_other(ports, other):
    program = socket_filter.program(ports)
    for port in {*list(ports)[:40], other}:
        assert passes(program, LOOPBACK_NUMBER, port) == (port in ports)
        assert not passes(program, 0xC0000202, port)


def test_of_too_many_ports_the_kernel_takes_those_that_fit():
    program = socket_filter.program(range(1, 65536))
    assert len(program) <= 4096
    assert passes(program, LOOPBACK_NUMBER, 3500)
    assert not passes(program, LOOPBACK_NUMBER, 5000)


@pytest.fixture
def segment(tmp_path, monkeypatch):
    monkeypatch.setattr(shared_memory, "_YOUNG", -1.0)
    (tmp_path / "fastrtps_0123456789abcdef_el").touch()
    path = tmp_path / "fastrtps_0123456789abcdef"
    path.write_bytes(bytes(100))
    return path


def test_shared_memory_without_an_owner_is_removed(segment, tmp_path):
    (tmp_path / "sem.fastrtps_0123456789abcdef_mutex").touch()
    (tmp_path / "others").touch()
    assert shared_memory.clean(tmp_path) == 100
    assert [path.name for path in tmp_path.iterdir()] == ["others"]


def test_shared_memory_of_the_living_and_of_the_young_stays(segment, tmp_path, monkeypatch):
    with segment.with_name(segment.name + "_el").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_SH)
        assert shared_memory.clean(tmp_path) == 0
    monkeypatch.setattr(shared_memory, "_YOUNG", 10.0)
    assert shared_memory.clean(tmp_path) == 0
    assert segment.exists()


def test_shared_memory_that_a_process_has_open_stays(segment, tmp_path):
    with segment.open("r+b") as file, mmap.mmap(file.fileno(), 0):
        assert shared_memory.clean(tmp_path) == 0
    assert shared_memory.clean(tmp_path) == 100


def test_shared_memory_is_closed_to_others(segment, tmp_path):
    segment.chmod(0o666)
    shared_memory.close_to_others(tmp_path)
    assert segment.stat().st_mode & 0o777 == 0o600


def test_a_port_in_shared_memory_that_another_user_holds_is_refused(tmp_path, monkeypatch):
    (tmp_path / "fastrtps_port7411").touch()
    (tmp_path / "fastrtps_port7411_el").touch()
    shared_memory.refuse_foreign(range(7400, 7650), tmp_path)
    owner = (tmp_path / "fastrtps_port7411").stat().st_uid
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    if owner:  # what root holds is believed
        with pytest.raises(ForeignMemoryError, match=f"user {owner}.*7411"):
            shared_memory.refuse_foreign(range(7400, 7650), tmp_path)
        shared_memory.refuse_foreign(range(7650, 7900), tmp_path)
