import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest
from bathbot_bringup.errors import ProcessError
from bathbot_bringup.graph.isolation import free_domain, used_ports
from bathbot_bringup.graph.processes import ProcessGroup, isolated_environment
from bathbot_depthcorr.node.dds.udp_ports import of_domain
from hypothesis import given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.graph

STUBBORN = """
import signal, time
signal.signal(signal.SIGINT, lambda *_: None)
signal.signal(signal.SIGTERM, lambda *_: None)
print("up", flush=True)
time.sleep(60)
"""


def python(code: str) -> list[str]:
    return [sys.executable, "-c", code]


@pytest.fixture
def group(tmp_path):
    with ProcessGroup(tmp_path / "logs", isolated_environment(99, tmp_path)) as group:
        yield group


def gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] == "Z"
    except OSError:
        return True


def wait_for(condition, timeout=10.0):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_dead_child_is_named_with_its_last_line(group):
    group.start("calm", python("import time; time.sleep(60)"))
    group.start("hasty", python("print('first'); print('cannot find the model'); raise SystemExit(2)"))
    with pytest.raises(
        ProcessError, match="node hasty ended with exit code 2; its last line: cannot find the model"
    ):
        group.wait_until(lambda name: name == "calm", timeout=10.0)


def test_a_child_killed_by_a_signal_is_named(group):
    child = group.start("driver", python("import time; time.sleep(60)"))
    child.process.kill()
    child.process.wait()
    with pytest.raises(ProcessError, match="driver was ended by signal 9; it wrote nothing"):
        group.check()


def test_a_child_that_is_never_ready_is_named(group):
    group.start("sleeper", python("import time; print('still loading', flush=True); time.sleep(60)"))
    with pytest.raises(ProcessError, match="sleeper was not active within 1 s; its last line: still loading"):
        group.wait_until(lambda name: False, timeout=1.0)


def test_stop_leaves_nothing_behind_even_of_the_stubborn(tmp_path):
    patience = [(signal.SIGINT, 0.5), (signal.SIGTERM, 0.3), (signal.SIGKILL, 5.0)]
    group = ProcessGroup(tmp_path, isolated_environment(99, tmp_path), patience)
    children = [
        group.start("polite", python("import time; time.sleep(60)")),
        group.start("stubborn", python(STUBBORN)),
    ]
    wait_for(lambda: children[1].last_line() == "up")
    group.stop()
    assert [child.process.poll() for child in children] == [-signal.SIGINT, -signal.SIGKILL]


def test_what_others_need_to_end_in_order_ends_last(tmp_path):
    """Started first, like the emulated controller; the other is slow to leave and says what it found."""
    leaving = textwrap.dedent("""
        import os, signal, sys, time
        def leave(*_):
            time.sleep(0.5)
            os.kill(int(sys.argv[1]), 0)
            print("it is there still", flush=True)
            raise SystemExit
        signal.signal(signal.SIGINT, leave)
        print("up", flush=True)
        time.sleep(60)
    """)
    group = ProcessGroup(tmp_path, isolated_environment(99, tmp_path))
    needed = group.start("needed", python("import time; time.sleep(60)"), last=True)
    other = group.start("other", [*python(leaving), str(needed.process.pid)])
    wait_for(lambda: other.last_line() == "up")
    group.stop()
    assert other.last_line().endswith("it is there still")
    assert needed.process.poll() == -signal.SIGINT


def test_an_exception_ends_the_children(tmp_path):
    started = []

    def fail():
        with ProcessGroup(tmp_path, isolated_environment(99, tmp_path)) as group:
            started.append(group.start("node", python("import time; time.sleep(60)")))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert started[0].process.poll() is not None


def test_children_end_when_the_program_is_killed(tmp_path):
    program = textwrap.dedent(f"""
        import sys, time
        from pathlib import Path
        from bathbot_bringup.graph.processes import ProcessGroup, isolated_environment
        group = ProcessGroup(Path({str(tmp_path)!r}), isolated_environment(99, Path({str(tmp_path)!r})))
        child = group.start("node", [sys.executable, "-c", "import time; time.sleep(60)"])
        print(child.process.pid, flush=True)
        time.sleep(60)
    """)
    with subprocess.Popen(python(program), stdout=subprocess.PIPE, text=True) as parent:
        pid = int(parent.stdout.readline())
        parent.kill()
    wait_for(lambda: gone(pid))


INFO, ERROR = "[INFO] [1.5] [n]: ", "[ERROR] [1.6] [n]: "


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        pytest.param(
            f"{INFO}ready\n{ERROR}no file x\n{INFO}shut down\n", "no file x", id="error before farewell"
        ),
        pytest.param(f"{INFO}configured\n", "configured", id="information when there is nothing else"),
        pytest.param("Traceback:\n  File x\nValueError: bad\n\n", "ValueError: bad", id="end of a traceback"),
    ],
)
def test_the_line_that_tells_most_is_quoted(group, lines, told):
    child = group.start("node", python(f"print({lines!r})"))
    child.process.wait()
    assert child.last_line() == told


def test_the_environment_isolates_the_graph(tmp_path):
    environment = isolated_environment(17, tmp_path)
    assert environment["ROS_DOMAIN_ID"] == "17"
    assert environment["OMP_NUM_THREADS"] == "1"


def test_niceness_is_applied(group):
    child = group.start("camera", python("import time; time.sleep(60)"), niceness=10)
    assert os.getpriority(os.PRIO_PROCESS, child.process.pid) >= 10


@settings(deadline=None)
@given(wish=st.integers(0, 4_000_000), taken=st.sets(st.integers(7400, 7400 + 250 * 101), max_size=40))
def test_a_free_domain_has_no_port_in_use(wish, taken):
    domain = free_domain(wish, taken)
    assert 1 <= domain <= 100
    if len({(port - 7400) // 250 for port in taken} & set(range(1, 101))) < 100:
        assert not set(of_domain(domain)) & taken


def test_when_all_domains_are_taken_one_is_shared():
    assert free_domain(7, range(7400, 40000)) == 8


def test_ports_in_use_are_seen():
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        assert listener.getsockname()[1] in used_ports()
