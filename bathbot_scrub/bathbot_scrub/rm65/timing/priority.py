"""Being served in time: what a process and a thread may ask of the scheduler."""

import contextlib
import os
import sys
import threading

_HANDED_OVER = 0.0001  # [s] after which a thread that waits for the interpreter gets it; Python's own: 0.005


def prefer_process() -> None:
    """Ask for this process and all its threads to come to be served first; not granted is no error.

    Call it before the first thread starts. The control loop alone is not enough: it waits for the
    interpreter while another thread holds it, and that thread must not be put aside meanwhile, nor hold
    it for long.
    """
    sys.setswitchinterval(_HANDED_OVER)
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except (OSError, AttributeError):
        with contextlib.suppress(OSError, AttributeError):
            os.setpriority(os.PRIO_PROCESS, 0, min(os.getpriority(os.PRIO_PROCESS, 0), -10))


def raise_priority() -> str:
    """Ask for real-time scheduling of the calling thread; say what it has."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))
    except (OSError, AttributeError):
        try:
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), -10)
        except (OSError, AttributeError):
            return "ordinary priority (no permission for more)"
        return "nice -10"
    return "SCHED_FIFO 20"
