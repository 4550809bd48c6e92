"""What the driver does at one moment."""

from typing import NamedTuple

from bathbot_scrub.rm65.guard_states import State


class Snapshot(NamedTuple):
    """What the driver does now; the fields of bathbot_msgs/ArmState."""

    state: State
    reason: str
    connected: bool
    path_id: int
    segment_index: int
    segments_queued: int
    distance_along: float  # [m]
    path_done: bool
    force: float  # [N] filtered resultant, NaN when unknown
    force_threshold: float  # [N]
    period: float  # [s]
    period_deviation_p99: float  # [s]
