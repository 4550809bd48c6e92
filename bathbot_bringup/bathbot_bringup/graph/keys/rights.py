"""What each holder of a key may hear and say, in the words of DDS Security: governance and permissions.

Topics carry the names that ROS gives them in DDS: `rt/x` is the topic /x, `rq/xRequest` and `rr/xReply` are
the two halves of the service /x, an action is three services and two topics. `*` fits any text, slashes
included. What no rule allows is refused.
"""

from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

_SCHEMA = "http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_{}.xsd"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_DISCOVERY = "ros_discovery_info"  # who has which node: each program of ROS says and hears it
_ALWAYS_SAID = ("rt/rosout", "rt/parameter_events")  # publishers that each node of rclpy has
_OF_WATCHERS = ("watcher/*", "_ros2cli_*")  # nodes in a namespace of theirs, and those of the `ros2` commands
_PROTECTED = ("discovery", "liveliness", "rtps")
_GUARDED = ("discovery_protection", "liveliness_protection", "read_access_control", "write_access_control")


class Enclave(NamedTuple):
    """Programs that hold one key, and their rights.

    Attributes:
        name: As ROS names it.
        about: What its holders can do, for a person.
        publish: Patterns of the DDS topics they may write.
        subscribe: Of those they may read.
    """

    name: str
    about: str
    publish: tuple[str, ...]
    subscribe: tuple[str, ...]


def robot() -> Enclave:
    """Nodes and commands of the robot: all topics, services and actions of ROS, in any namespace."""
    everything = (_DISCOVERY, "rt/*", "rq/*Request", "rr/*Reply")
    return Enclave(
        "/bathbot/robot", "sees all, pictures of the person too, and moves the arm", everything, everything
    )


def watcher(shown: Iterable[str]) -> Enclave:
    """Programs that look on: they hear what they are shown, call nothing and command nothing.

    A node is not made unless it may say log lines and events of its parameters and serve its own services;
    it serves them under names of watchers only.

    Args:
        shown: Patterns of resolved topic names, such as `*/wrench`.
    """
    return Enclave(
        "/bathbot/watcher",
        "hears what the privacy profile metrics_only records: numbers, no picture; commands nothing",
        (_DISCOVERY, *_ALWAYS_SAID, *(f"rr/{mine}Reply" for mine in _OF_WATCHERS)),
        (_DISCOVERY, *(f"rt{topic}" for topic in shown), *(f"rq/{mine}Request" for mine in _OF_WATCHERS)),
    )


def governance(domains: Sequence[int]) -> str:
    """The rules of these domains, as XML: nobody without a key, everything encrypted, all access checked."""
    dds = _document("governance")
    rule = _add(_add(dds, "domain_access_rules"), "domain_rule")
    _add_domains(rule, domains)
    _add(rule, "allow_unauthenticated_participants", "false")
    _add(rule, "enable_join_access_control", "true")
    for what in _PROTECTED:
        _add(rule, f"{what}_protection_kind", "ENCRYPT")
    topics = _add(_add(rule, "topic_access_rules"), "topic_rule")
    _add(topics, "topic_expression", "*")
    for what in _GUARDED:
        _add(topics, f"enable_{what}", "true")
    for what in ("metadata", "data"):
        _add(topics, f"{what}_protection_kind", "ENCRYPT")
    return _text(dds)


def permissions(enclave: Enclave, domains: Sequence[int], begin: datetime, end: datetime) -> str:
    """What the holders of one key may do in these domains from begin to end (both UTC), as XML."""
    dds = _document("permissions")
    grant = _add(_add(dds, "permissions"), "grant")
    grant.set("name", enclave.name)
    _add(grant, "subject_name", f"CN={enclave.name}")
    validity = _add(grant, "validity")
    for name, time in (("not_before", begin), ("not_after", end)):
        _add(validity, name, f"{time:%Y-%m-%dT%H:%M:%SZ}")
    rule = _add(grant, "allow_rule")
    _add_domains(rule, domains)
    for verb, patterns in (("publish", enclave.publish), ("subscribe", enclave.subscribe)):
        topics = _add(_add(rule, verb), "topics")
        for pattern in patterns:
            _add(topics, "topic", pattern)
    _add(grant, "default", "DENY")
    return _text(dds)


def _document(kind: str) -> Element:
    return Element("dds", {"xmlns:xsi": _XSI, "xsi:noNamespaceSchemaLocation": _SCHEMA.format(kind)})


def _add(parent: Element, name: str, text: str | None = None) -> Element:
    child = ElementTree.SubElement(parent, name)
    child.text = text
    return child


def _add_domains(parent: Element, domains: Sequence[int]) -> None:
    listed = _add(parent, "domains")
    for domain in domains:
        _add(listed, "id", str(domain))


def _text(document: Element) -> str:
    ElementTree.indent(document)
    return ElementTree.tostring(document, encoding="unicode") + "\n"
