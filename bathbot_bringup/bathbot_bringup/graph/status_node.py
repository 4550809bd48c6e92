"""What a running graph says of itself, in plain words: the arm, its nodes' complaints, the regions seen."""

import math
from typing import Any

from bathbot_scrub.arm.states import State
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import qos_profile_sensor_data

from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_msgs.msg import ArmState, ContactTargets

_OK = b"\x00"
_LISTEN = 1.2  # [s] in which every node tells how it is


def hear_status(client: GraphClient, namespace: str, patience: float) -> list[str]:
    """Lines on the arm and on every node that complains.

    Raises:
        StepError: When no arm is heard within `patience` [s].
    """
    complaints: dict[str, str] = {}

    def on_diagnostics(message: DiagnosticArray) -> None:
        for one in message.status:
            complaints[one.name] = "" if one.level == _OK else one.message

    client.node.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, 50)
    state = _first(client, ArmState, "arm_state", namespace, patience)
    client.wait(_LISTEN)
    return [
        f"arm: {State(state.state).name}{f', {state.reason}' if state.reason else ''}",
        f"force: {state.force:.1f} N, retracts above {state.force_threshold:.1f} N",
        *([] if state.connected else ["the controller is not connected"]),
        *(f"{name}: {said}" for name, said in sorted(complaints.items()) if said),
    ]


def hear_regions(client: GraphClient, namespace: str, patience: float) -> list[str]:
    """A line for each region that has a contact target.

    Raises:
        StepError: When no localiser is heard within `patience` [s].
    """
    targets = _first(client, ContactTargets, "contact_targets", namespace, patience).targets
    return [
        f"{target.region}: score {target.score:.2f}, at ({place.x:.2f}, {place.y:.2f}, {place.z:.2f}) m from "
        f"the arm's base, known to {1e3 * math.sqrt(max(sum(target.pose.covariance[:15:7]), 0.0)):.1f} mm"
        for target in targets
        for place in [target.pose.pose.position]
    ] or ["no region of bare skin is seen that could be touched"]


def _first(client: GraphClient, kind: type, topic: str, namespace: str, patience: float) -> Any:
    heard: list[Any] = []
    name = "/".join(filter(None, (namespace.strip("/"), topic)))
    client.node.create_subscription(kind, name, heard.append, qos_profile_sensor_data)
    if not client.spin_until(lambda: heard, patience):
        raise StepError("listening", f"nobody says anything on {name}; is its node running, on this domain?")
    return heard[-1]
