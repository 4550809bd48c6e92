"""States of the arm that somebody else sends to the driver; the judge is the true force in the emulator."""

import json
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest
from bathbot_bringup.sim.arm.controller.push import PushSettings, datagram
from bathbot_scrub.arm.states import State
from emulator_cell import running, until

pytestmark = pytest.mark.graph

FLOOD = """
import socket, sys
data, to = sys.stdin.buffer.read(), ("127.0.0.1", int(sys.argv[1]))
sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
while True:
    sender.sendto(data, to)
"""


def calm(cell):
    """The present state, with hardly any force on it."""
    state = json.loads(datagram(cell.emulator._desk.controller, PushSettings()).data)
    state["six_force_sensor"]["zero_force"] = [int(v) for v in np.random.default_rng().integers(-40, 40, 6)]
    return json.dumps(state).encode()


@contextmanager
def forger(cell):
    """Sends states of an arm that nobody presses on, from the controller's address but another port."""
    over = threading.Event()

    def forge():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            while not over.wait(0.002):
                sender.sendto(calm(cell), ("127.0.0.1", cell.driver.link.receiver.port))

    thread = threading.Thread(target=forge)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def flood(cell):
    """Sends the same state as fast as it can, likewise."""
    port = cell.driver.link.receiver.port
    process = subprocess.Popen([sys.executable, "-c", FLOOD, str(port)], stdin=subprocess.PIPE)
    process.stdin.write(calm(cell))
    process.stdin.close()
    try:
        time.sleep(0.5)
        yield
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("attack", [forger, flood])
def test_states_of_another_port_do_not_hide_who_leans_on_the_brush(attack):
    with running() as cell:
        cell.approach()
        until(lambda: cell.state() is State.CONTACT and not cell.driver.loop.moving)
        cell.emulator.trace.clear()
        with attack(cell):
            begun = time.monotonic()
            while time.monotonic() < begun + 1.0:
                cell.wall.shift = min(0.1 * (time.monotonic() - begun), 0.012)
                time.sleep(0.002)
        peak = np.linalg.norm(cell.emulator.trace.data().force, axis=1).max()
    assert peak < 12.0  # [N] 10 is the region's threshold for leaving


def test_where_somebody_else_sends_states_from_the_beginning_nobody_is_believed():
    with running() as cell:
        with forger(cell):
            cell.emulator.drop_clients()
            until(lambda: "two programs" in cell.driver.link.trouble)
            assert not cell.driver.snapshot().connected
        until(lambda: cell.driver.snapshot().connected)
