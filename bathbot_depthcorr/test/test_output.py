"""A process whose output nobody reads goes on, loses lines instead of time, and says so afterwards."""

import fcntl
import os
import pty
import subprocess
import sys
import termios

import pytest

pytestmark = pytest.mark.graph

BEGIN = """
import os, sys, threading
from bathbot_depthcorr.node.output import ROOM, Output
output = Output()
"""
TALK = """
import ctypes
below = ctypes.CDLL(None).write  # as C code writes, which does not mind
for number in range(40_000):
    line = f"{number:09d}........................................."
    if number % 2:
        print("above", line, file=sys.stderr)
    else:
        below(2, f"below {line}\\n".encode(), 57)
os.write(3, b"said")
"""
END = """
output.close(0.5)
os._exit(0)
"""


def python(code, **options):
    return subprocess.Popen([sys.executable, "-c", code], **options)


@pytest.fixture
def pipe():
    """Ends of a pipe that takes 4096 bytes."""
    ends = os.pipe()
    fcntl.fcntl(ends[1], fcntl.F_SETPIPE_SZ, 4096)
    yield ends
    for end in ends:
        os.close(end)


def writer(code, output):
    """A process whose output is `output`, and whose third descriptor tells how far it is."""
    read_end, write_end = os.pipe()
    process = python(
        f"import os; os.dup2({write_end}, 3)\n{code}", stdin=subprocess.PIPE, stdout=output, stderr=output,
        pass_fds=(write_end,),
    )  # fmt: skip
    os.close(write_end)
    return process, read_end


def test_more_lines_than_there_is_room_for_cost_no_time_and_are_missed(pipe):
    process, said = writer(BEGIN + TALK + "sys.stdin.read()" + END, pipe[1])
    with process, open(pipe[0], "rb", closefd=False) as reader:
        assert os.read(said, 4) == b"said"  # it went on, with four times what fits
        assert not fcntl.fcntl(pipe[1], fcntl.F_GETFL) & os.O_NONBLOCK  # ours, too: it is shared
        lines = []
        while not lines or b"[output]" not in lines[-1]:
            lines.append(reader.readline())
    os.close(said)
    assert b"lines were lost here" in lines[-1]
    whole = [line for line in lines if line[:5] in (b"above", b"below") and len(line) == 57]
    assert 10_000 < len(whole) < 40_000
    assert [int(line[6:15]) for line in whole] == list(range(len(whole)))  # in order, none in between


def test_what_was_said_last_is_read_after_the_end():
    process = python(BEGIN + "print('one'); print('two', file=sys.stderr); os.write(1, b'three\\n')" + END,
                     stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip
    assert process.communicate(timeout=20.0) == (b"one\nthree\n", b"two\n")
    assert process.returncode == 0


def test_a_terminal_that_stands_still_does_not_keep_the_process():
    keyboard, terminal = pty.openpty()
    termios.tcflow(terminal, termios.TCOOFF)  # Ctrl-S
    process = python(BEGIN + "print('unheard')" + END, stdout=terminal, stderr=terminal)
    assert process.wait(20.0) == 0
    os.close(terminal)
    os.close(keyboard)


def test_a_crash_is_told_where_it_would_have_been():
    process = python(BEGIN + "os.abort()", stderr=subprocess.PIPE)
    assert b"Fatal Python error: Aborted" in process.communicate(timeout=20.0)[1]
