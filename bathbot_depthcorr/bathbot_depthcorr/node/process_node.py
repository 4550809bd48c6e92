"""A process that is one node: from its start to an orderly end."""

import gc
import signal
import sys
import threading

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from bathbot_depthcorr.node.stage_node import StageNode


def run(node_type: type[StageNode]) -> None:
    """Run one node until Ctrl-C or SIGTERM; exit with 2 when it could not start.

    The signals only end the loop: the context stays valid until the node has left in order.
    """
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = None
    try:
        node = node_type()
        started = node.autostart()
        gc.freeze()  # what is loaded now stays: searching it for garbage would stop all threads for 0.1 s
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while started and not stopping.is_set():
            executor.spin_once(timeout_sec=0.1)
    except ParameterException as error:
        print(f"{node_type.__name__}: {error}", file=sys.stderr)
        started = False
    finally:
        if node is not None:
            node.end()
        rclpy.try_shutdown()
    raise SystemExit(0 if started else 2)
