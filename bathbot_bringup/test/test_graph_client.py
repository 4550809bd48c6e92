"""The client of the graph in a program of its own."""

import os
import subprocess
import sys

import pytest
from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.graph.isolation import free_domain, used_ports
from rclpy.task import Future
from std_srvs.srv import Trigger

pytestmark = pytest.mark.graph

PROGRAM = """
import os
from bathbot_bringup.bathing.client_node import Bather
from bathbot_bringup.graph.client_node import GraphClient
from rclpy.task import Future
from std_srvs.srv import Trigger

def threads():
    return len(os.listdir("/proc/self/task"))

with GraphClient("guest", {domain}) as client:
    bather = Bather(client, "Trunk_skin")
    client.is_active("nobody")
    client.spin_until(lambda: False, 0.2)
    inside = threads()
print(inside, threads())
"""


@pytest.fixture
def client():
    with GraphClient("guest", free_domain(os.getpid(), used_ports())) as client:
        yield client


def test_it_leaves_no_participant_behind():
    """The threads of DDS end with the client; they could hold up the end of the process."""
    program = PROGRAM.format(domain=free_domain(os.getpid(), used_ports()))
    outcome = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=30)
    assert outcome.returncode == 0, outcome.stderr
    inside, after = map(int, outcome.stdout.split())
    assert after <= inside - 6


def test_a_service_that_nobody_offers_is_named(client):
    with pytest.raises(StepError, match="home failed: nobody offers the service arm/home"):
        client.trigger("home", "arm/home", 0.3)


def test_a_node_that_does_not_exist_is_not_active(client):
    assert not client.is_active("nobody")


def test_what_the_watch_raises_ends_the_wait(client):
    def watch():
        raise StepError("watch", "something died")

    client.watch = watch
    with pytest.raises(StepError, match="something died"):
        client.spin_until(lambda: False, 5.0)


def test_a_service_is_asked_again_where_that_does_no_harm(client):
    """The first answer is lost, as when the server has not discovered its client yet."""
    asked = []
    client.node.create_service(Trigger, "forgetful", lambda request, response: asked.append(1) or response)
    sent, late = client.service(Trigger, "forgetful"), []
    send = sent.call_async
    sent.call_async = lambda request: late.append(1) or (send(request) if len(late) > 1 else Future())
    assert client.call("ask", Trigger, "forgetful", Trigger.Request(), 4.0, tries=2) is not None
    assert (len(late), len(asked)) == (2, 1)


def test_one_client_serves_all_calls_of_a_service(client):
    assert client.service(Trigger, "arm/home") is client.service(Trigger, "arm/home")
