"""A process joins the graph: from then on nobody reaches it but whom the reach allows."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy import get_default_context
from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation

from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.node.dds import reach, ros_words, shared_memory, transport, udp_ports
from bathbot_depthcorr.node.dds.peer_filter import PeerFilter, own_sockets
from bathbot_depthcorr.node.dds.reach import Reach

os.environ.update(transport.variables())  # which the first context reads

_STDERR = 2


def begin(**options: Any) -> None:
    """Do what `rclpy.init` does, and say in one line why it cannot be done; ROS takes many.

    Raises:
        SettingsError: When the environment asks for a reach that cannot be kept to, or ROS refuses it.
    """
    reach.chosen()
    ros_words.domain()
    with tempfile.TemporaryFile() as said:
        errors = os.dup(_STDERR)
        os.dup2(said.fileno(), _STDERR)
        try:
            rclpy.init(**options)
        except (rclpy_implementation.RCLError, rclpy_implementation.UnknownROSArgsError) as error:
            raise SettingsError(ros_words.told(error)) from error
        finally:
            os.dup2(errors, _STDERR)
            os.close(errors)
        said.seek(0)
        os.write(_STDERR, said.read())


@contextmanager
def joining(context: Context | None = None) -> Iterator[Reach]:
    """Make a node within this, or nobody keeps strangers from it; gives the reach.

    Args:
        context: The node's; None: the default one.

    Raises:
        SettingsError: When the environment asks for a reach that cannot be kept to, or DDS refuses its keys.
        ForeignMemoryError: When another user sits where this process would be spoken to.
    """
    wanted = reach.chosen()
    if wanted is Reach.NETWORK:
        try:
            yield wanted
        except rclpy_implementation.RCLError as error:  # the context is joined with the first node
            raise SettingsError(
                f"no node can join with these keys: {' '.join(str(error).split())}; docs/privacy.md tells "
                "what they allow; the Fast DDS of Ubuntu's ROS was built with security, pip's was not"
            ) from error
        return
    shared_memory.clean()
    if transport.shares_memory():
        shared_memory.refuse_foreign(udp_ports.of_domain((context or get_default_context()).get_domain_id()))
    before = own_sockets()
    yield wanted
    shared_memory.close_to_others()
    if wanted is Reach.USER:
        _FILTER.watch(own_sockets() - before)


_FILTER = PeerFilter()
