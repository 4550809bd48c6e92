"""The commands for a person without ros2cli, typed in another shell while a graph runs."""

import os
import subprocess
import sys
import tempfile

import pytest
from bathbot_bringup.errors import InputError
from bathbot_bringup.graph import register
from bathbot_bringup.graph.isolation import free_ports
from bathbot_bringup.graph.running import running


@pytest.fixture(scope="module")
def graph(tmp_path_factory):
    ports = free_ports()
    nodes = {
        "sim_rm65": {"port": ports.tcp, "udp_port": ports.udp, "scenario": "still"},
        "rm65_driver": {"host": "127.0.0.1", "port": ports.tcp, "udp_port": ports.udp},
    }
    with running(nodes, tmp_path_factory.mktemp("arm"), "bathbot_test") as graph:
        yield graph


def bathbot(*words, **environment):
    kept = {name: value for name, value in os.environ.items() if name != "ROS_DOMAIN_ID"} | environment
    command = [sys.executable, "-m", "bathbot_bringup.command.cli", *words]
    done = subprocess.run(command, env=kept, capture_output=True, text=True, timeout=60, check=False)
    assert "Traceback" not in done.stderr
    return done


@pytest.mark.graph
def test_the_arm_is_told_and_asked(graph):
    domain = ("--domain", str(graph.domain))
    told = bathbot("status", *domain)
    assert (told.returncode, told.stdout.splitlines()[0][:5]) == (0, "arm: ")
    assert "force: " in told.stdout
    assert bathbot("stop", *domain).returncode == 0
    assert "HOLD" in bathbot("status", *domain).stdout
    refused = bathbot("resume", *domain)
    assert (refused.returncode, refused.stderr) == (
        2, "bathbot: resume failed: nothing is paused; the arm is in state HOLD\n"
    )  # fmt: skip
    assert bathbot("home", *domain).returncode == 0


@pytest.mark.graph
def test_the_graph_that_runs_is_found(graph):
    assert graph.domain in register.running_domains()
    if register.running_domains() == [graph.domain]:  # else somebody else of this user runs one
        assert bathbot("status").returncode == 0


@pytest.mark.graph
def test_where_nobody_runs_it_is_said_in_one_line(graph):
    for verb, said in (("stop", "nobody offers the service arm/stop"), ("status", "nobody says anything")):
        refused = bathbot(verb, "--domain", "101")
        assert refused.returncode == 2
        assert said in refused.stderr
        assert len(refused.stderr.splitlines()) == 1


def test_a_domain_is_found_by_what_is_said_first(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    assert register.find_domain(None) == 0
    with register.registered(7):
        assert register.find_domain(None) == 7
        assert register.find_domain(9) == 9
        with register.registered(8), pytest.raises(InputError, match="domains 7, 8; say which"):
            register.find_domain(None)
        monkeypatch.setenv("ROS_DOMAIN_ID", "5")
        assert register.find_domain(None) == 5
    assert register.running_domains() == []


def test_a_place_that_is_somebody_elses_is_not_believed(tmp_path, monkeypatch):
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with register.registered(7):
        owner = tmp_path.stat().st_uid
        (tmp_path / f"bathbot-{owner}").rename(tmp_path / f"bathbot-{owner + 1}")
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
        assert register.running_domains() == []
        with pytest.raises(InputError, match="is another user's"), register.registered(8):
            pytest.fail("it was told there")


def test_a_graph_whose_process_has_died_does_not_run(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with register.registered(7):
        (tmp_path / "bathbot" / "7").write_text("4194305")  # no process can have this number
        assert register.running_domains() == []


@pytest.mark.graph
def test_two_do_not_bathe_at_once_and_one_that_was_killed_holds_up_nobody(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    code = (
        "import time\nfrom bathbot_bringup.graph.register import alone\n"
        "with alone():\n    print('begun', flush=True)\n    time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "begun\n"
        with pytest.raises(InputError, match=f"process {other.pid} bathes on this machine"), register.alone():
            pytest.fail("two at once")
        other.kill()
    for _ in range(2):
        with register.alone():
            assert register.running_domains() == []
