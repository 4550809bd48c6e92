"""A process that is one node: from its start to an orderly end."""

import gc
import os
import signal
import sys
import threading
from typing import NoReturn

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from bathbot_depthcorr.node.stage_node import StageNode


def run(node_type: type[StageNode]) -> None:
    """Run one node until Ctrl-C or SIGTERM, then end the process; with exit code 2 when it could not start.

    The signals only end the loop: the context stays valid until the node has left in order.
    """
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    _leave(0 if _served(node_type, stopping) else 2)


def _served(node_type: type[StageNode], stopping: threading.Event) -> bool:
    """Serve one node until told to stop; false when it could not start. Everything has ended afterwards."""
    node = executor = None
    try:
        node = node_type()
        started = node.autostart()
        gc.freeze()  # what is loaded now stays: searching it for garbage would stop all threads for 0.1 s
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while started and not stopping.is_set():
            executor.spin_once(timeout_sec=0.1)
        return started
    except ParameterException as error:
        print(f"{node_type.__name__}: {error}", file=sys.stderr)
        return False
    finally:
        if executor is not None:
            executor.shutdown()
        if node is not None:
            node.end()
        rclpy.try_shutdown()


def _leave(code: int) -> NoReturn:
    """End this process without the destructors of its libraries.

    Those of Fast DDS race with its own threads, and a node that had ended in order died of signal 11.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
