"""A process that is one node: from its start to an orderly end."""

import gc
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from bathbot_depthcorr.errors import BathbotError, SettingsError
from bathbot_depthcorr.files import keep_private
from bathbot_depthcorr.node.dds.participant_node import begin
from bathbot_depthcorr.node.output import Output
from bathbot_depthcorr.node.stage_node import StageNode

_PATIENCE = 1.0  # [s] for the last lines: a terminal that stands still must not keep the process


def run(
    node_type: type[StageNode], *arguments: str, executor: Callable[[], Executor] = EventsExecutor
) -> None:
    """Run one node until Ctrl-C, SIGTERM or the end of its terminal, then end the process.

    The exit code is 2 when it could not start. The signals only end the loop: the context stays valid until
    the node has left in order. The process ends without the destructors of its libraries: those of Fast DDS
    race with its own threads, and a node that had ended in order died of signal 11.

    Args:
        node_type: The node.
        arguments: Of ROS, before those of the command line.
        executor: Serves it. By default one that is told of events: those that wait build the set of all that
            may come anew for each message, which cost the camera nearly as much as its pictures.
    """
    keep_private()
    output = Output()
    stopping = threading.Event()
    _heed_signals(stopping)
    command = [sys.argv[0], "--ros-args", *arguments, "--", *sys.argv[1:]]
    try:
        begin(args=command, signal_handler_options=SignalHandlerOptions.NO)
        server = executor()
        _heed_signals(stopping)  # some versions of EventsExecutor take them; all take the word about crashes
        output.tell_crashes()
        code = 0 if _served(node_type, server, stopping) else 2
    except SettingsError as error:
        print(f"{node_type.__name__}: {error}", file=sys.stderr)
        code = 2
    except Exception:
        traceback.print_exc()
        code = 1
    output.close(_PATIENCE)
    os._exit(code)


def _heed_signals(stopping: threading.Event) -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # as `nohup` has it
            signal.signal(number, lambda *_: stopping.set())


def _served(node_type: type[StageNode], executor: Executor, stopping: threading.Event) -> bool:
    """Serve one node until told to stop; false when it could not start. Everything has ended afterwards."""
    node = None
    try:
        node = node_type()
        started = node.autostart()
        gc.freeze()  # what is loaded now stays: searching it for garbage would stop all threads for 0.1 s
        executor.add_node(node)
        while started and not stopping.is_set():
            executor.spin_once(timeout_sec=0.1)
        return started
    except (ParameterException, BathbotError) as error:
        print(f"{node_type.__name__}: {error}", file=sys.stderr)
        return False
    finally:
        executor.shutdown()
        if node is not None:
            node.end()
        rclpy.try_shutdown()
        node = None
        gc.unfreeze()
        gc.collect()  # the last handle lets go of the DDS participant, and that of its shared memory
