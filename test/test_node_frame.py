"""The frame of a node over DDS: its parameters teach, its endpoints end, its long actions do not block."""

import os
import subprocess
import sys
import threading
from dataclasses import dataclass

import pytest
import rclpy
from bathbot_depthcorr.errors import BathbotError, SettingsError
from bathbot_depthcorr.node.parameters import check, declared, setting
from bathbot_depthcorr.node.stage_node import StageNode
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters, SetParametersAtomically
from rclpy.action import ActionClient
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String
from std_srvs.srv import Trigger
from test_settings import NODES, settings_type

from bathbot_msgs.action import Approach

pytestmark = pytest.mark.graph


@dataclass(frozen=True, slots=True)
class Settings:
    rate: float = setting(5.0, "Rate at which nothing in particular is done", "Hz", above=0.0, high=100.0)
    count: int = setting(2, "Number of things that nobody ever counted", low=1)

    def __post_init__(self) -> None:
        check(self, SettingsError)


class Stage(StageNode):
    """Has one of everything."""

    def __init__(self, **options) -> None:
        super().__init__("stage", Settings, **options)
        self.gate, self.heard, self.ended = threading.Event(), [], []

    def setup(self, settings: Settings) -> None:
        self.settings = settings
        self.words = self.publisher(String, "words", 10)

    def start(self) -> None:
        self.workshop = self.worker(self._say, self.heard.append)
        self.listen(String, "orders", self.workshop.put, 10)
        self.every(0.05, lambda: self.words.publish(String(data="tick")))
        self.offer("quick", self._refuse)
        self.offer_beside("slow", self._wait)
        self.action = self.act(Approach, "approach", begin=self._begin, conclude=self._conclude,
                               cancel=self.gate.set)  # fmt: skip

    def stop(self) -> None:
        self.gate.set()

    def _say(self, order: String) -> None:
        self.words.publish(order)

    def _refuse(self) -> None:
        raise BathbotError("not today")

    def _wait(self) -> str:
        assert self.gate.wait(10.0)
        return "the gate is open"

    def _begin(self, goal: ServerGoalHandle) -> None:
        if goal.request.standoff < 0.0:
            self.action.end(goal, "no such force")
        else:
            self.action.run(goal, self._wait)

    def _conclude(self, goal: ServerGoalHandle, outcome: str) -> Approach.Result:
        self.ended.append(outcome)
        if goal.is_cancel_requested:
            goal.canceled()
        elif outcome == self._wait():
            goal.succeed()
        else:
            goal.abort()
        return Approach.Result(error_msg=outcome)


@pytest.fixture
def stage(graph):
    node, client = Stage(), rclpy.create_node("client")
    assert node.autostart()
    graph.start(node, client)
    return node, client


def ask(graph, client: Node, kind: type, name: str, request=None):
    caller = client.create_client(kind, name)
    graph.wait_for(caller.service_is_ready)
    return caller.call_async(request or kind.Request())


def change(graph, client: Node, transition: int, node: str = "stage") -> None:
    request = ChangeState.Request(transition=Transition(id=transition))
    assert answer(graph, ask(graph, client, ChangeState, f"{node}/change_state", request)).success


def answer(graph, future):
    graph.wait_for(future.done)
    return future.result()


def test_parameters_describe_themselves_and_refuse_to_change(graph, stage):
    _, client = stage
    request = DescribeParameters.Request(names=["rate", "count", "autostart"])
    told = answer(graph, ask(graph, client, DescribeParameters, "stage/describe_parameters", request))
    rate, count, autostart = told.descriptors
    assert autostart.description.startswith("Whether the node configures and activates itself")
    assert rate.description == "Rate at which nothing in particular is done [Hz]"
    assert rate.additional_constraints == "must lie in 0..100 Hz, 0 left out"
    assert rate.floating_point_range[0].to_value == 100.0
    assert count.integer_range[0].from_value == 1
    assert rate.read_only
    change = SetParameters.Request(parameters=[Parameter("rate", value=7.0).to_parameter_msg()])
    (result,) = answer(graph, ask(graph, client, SetParameters, "stage/set_parameters", change)).results
    assert not result.successful
    assert "read-only" in result.reason


@pytest.mark.parametrize(
    ("values", "settings"),
    [
        pytest.param({}, Settings(), id="defaults"),
        pytest.param({"rate": 7}, Settings(rate=7.0), id="a whole number for a float"),
        pytest.param({"rate": 7.5, "count": 3}, Settings(7.5, 3), id="both"),
    ],
)
def test_parameters_become_settings(graph, values, settings):
    node = Stage(parameter_overrides=[Parameter(name, value=value) for name, value in values.items()])
    graph.start(node)
    assert node.autostart()
    assert node.settings == settings


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        pytest.param("rate", 0.0, "rate must lie in 0..100 Hz, 0 left out, got 0.0", id="the end left out"),
        pytest.param("rate", 101.0, "got 101.0; the default is 5.0", id="above"),
        pytest.param("rate", 101, "got 101.0", id="a whole number above"),
        pytest.param("rate", float("nan"), "got nan", id="nan"),
        pytest.param("count", 0, "count must be 1 or more, got 0", id="below"),
        pytest.param("count", 2.5, "count must be a int, got 2.5", id="no whole number"),
        pytest.param("rate", "fast", "rate must be a float, got 'fast'", id="a word"),
    ],
)
def test_a_refused_parameter_is_told_on_configure(graph, name, value, said):
    node = Stage(parameter_overrides=[Parameter(name, value=value)])
    graph.start(node)
    assert not node.autostart()
    assert said in node.diagnostic.status.message


def test_what_a_phase_made_ends_with_it_and_comes_again(graph, stage):
    node, client = stage
    said = []
    client.create_subscription(String, "words", lambda message: said.append(message.data), 10)
    orders = client.create_publisher(String, "orders", 10)
    graph.wait_for(lambda: orders.get_subscription_count() == 1 and "tick" in said)
    graph.wait_for(lambda: orders.publish(String(data="hello")) or "hello" in said)
    ours = lambda: [name for name, _ in client.get_service_names_and_types()]  # noqa: E731
    graph.wait_for(lambda: {"/quick", "/slow"} <= set(ours()))

    change(graph, client, Transition.TRANSITION_DEACTIVATE)
    graph.wait_for(lambda: orders.get_subscription_count() == 0 and "/slow" not in ours())
    graph.wait_for(lambda: client.count_publishers("words") == 1)
    change(graph, client, Transition.TRANSITION_CLEANUP)
    graph.wait_for(lambda: client.count_publishers("words") == 0)

    change(graph, client, Transition.TRANSITION_CONFIGURE)
    change(graph, client, Transition.TRANSITION_ACTIVATE)
    graph.wait_for(lambda: orders.get_subscription_count() == 1 and {"/quick", "/slow"} <= set(ours()))
    assert not node.heard


def test_services_say_why_and_do_not_wait_for_each_other(graph, stage):
    node, client = stage
    slow = ask(graph, client, Trigger, "slow")
    quick = answer(graph, ask(graph, client, Trigger, "quick"))
    assert (quick.success, quick.message) == (False, "not today")
    assert not slow.done()
    node.gate.set()
    late = answer(graph, slow)
    assert (late.success, late.message) == (True, "the gate is open")


def send(graph, client: Node, **goal):
    actions = ActionClient(client, Approach, "approach")
    graph.wait_for(actions.server_is_ready)
    future = actions.send_goal_async(Approach.Goal(**goal))
    return answer(graph, future)


def test_a_long_goal_leaves_the_executor_free_and_ends_with_its_outcome(graph, stage):
    node, client = stage
    goal = send(graph, client)
    result = goal.get_result_async()
    assert not answer(graph, ask(graph, client, Trigger, "quick")).success
    assert not result.done()
    node.gate.set()
    ended = answer(graph, result)
    assert ended.result.error_msg == "the gate is open"
    assert node.ended == ["the gate is open"]


def test_a_goal_may_end_as_it_begins(graph, stage):
    node, client = stage
    node.gate.set()
    ended = answer(graph, send(graph, client, standoff=-1.0).get_result_async())
    assert ended.result.error_msg == "no such force"


def test_a_cancelled_goal_is_told_and_ends(graph, stage):
    _, client = stage
    goal = send(graph, client)
    result = goal.get_result_async()
    answer(graph, goal.cancel_goal_async())
    assert answer(graph, result).result.error_msg == "the gate is open"


@pytest.fixture
def driver(graph):
    """The arm's driver in a process of its own, as a user runs it, not configured; gives a client's node."""
    values = {"autostart": "false", "udp_port": 0, "port": 1}
    told = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(graph.domain)}
    process = subprocess.Popen(
        [sys.executable, "-m", NODES["rm65_driver"], "--ros-args", *told],
        env=environment,
        stdout=subprocess.DEVNULL,
    )
    client = rclpy.create_node("client")
    graph.start(client)
    try:
        caller = client.create_client(DescribeParameters, "rm65_driver/describe_parameters")
        graph.wait_for(caller.service_is_ready, 40.0)
        yield client
    finally:
        process.terminate()
        process.wait(20.0)


def test_the_drivers_limits_and_deadlines_cannot_be_changed_in_any_state(graph, driver):
    """Neither one by one nor all at once, nor taken away: not configured, inactive, active, and back."""
    wanted = {"force_limits": "other.yaml", "brake_after": 0.1, "leave_after": 15.0, "body_max_age": 9.0}
    wanted |= {"home_needs_consent": False, "approach_speed": 0.05, "tool_mass": 0.5, "retract_speed": 0.2}
    changes = [Parameter(name, value=value).to_parameter_msg() for name, value in wanted.items()]
    gone = [Parameter(name).to_parameter_msg() for name in wanted]

    def held():
        values = ask(
            graph, driver, GetParameters, "rm65_driver/get_parameters", GetParameters.Request(names=[*wanted])
        )
        return answer(graph, values).values

    begun = held()
    for transition in (
        None,
        Transition.TRANSITION_CONFIGURE,
        Transition.TRANSITION_ACTIVATE,
        Transition.TRANSITION_DEACTIVATE,
        Transition.TRANSITION_CLEANUP,
    ):
        if transition is not None:
            change(graph, driver, transition, "rm65_driver")
        for asked in (changes, gone):
            singly = ask(
                graph,
                driver,
                SetParameters,
                "rm65_driver/set_parameters",
                SetParameters.Request(parameters=asked),
            )
            together = ask(
                graph, driver, SetParametersAtomically, "rm65_driver/set_parameters_atomically",
                SetParametersAtomically.Request(parameters=asked),
            )  # fmt: skip
            results = [*answer(graph, singly).results, answer(graph, together).result]
            assert len(results) == len(wanted) + 1
            assert not any(result.successful for result in results)
            assert all("read-only" in result.reason for result in results)
        assert held() == begun


def test_a_node_of_ours_describes_all_its_parameters(graph, driver):
    names = list(declared(settings_type(NODES["rm65_driver"])))
    request = DescribeParameters.Request(names=names)
    described = ask(graph, driver, DescribeParameters, "rm65_driver/describe_parameters", request)
    told = answer(graph, described).descriptors
    for name, descriptor in zip(names, told, strict=True):
        entry = declared(settings_type(NODES["rm65_driver"]))[name]
        assert (descriptor.description, descriptor.additional_constraints) == (entry.description, entry.rule)
        assert descriptor.read_only
