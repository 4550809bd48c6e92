"""What a bathing run left in its bag, as arrays."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bathbot_depthcorr.ros.image_decoding import stamp_seconds
from bathbot_depthcorr.ros.pose_decoding import transform_from_pose, transforms_from_poses
from numpy.typing import NDArray

from bathbot_bringup.bag.reading import Entry, read_messages

Array = NDArray[np.float64]


class ArmStates(NamedTuple):
    """The driver's reports over time; all of shape (N,)."""

    time: Array  # [s]
    state: NDArray[np.int64]
    path_id: NDArray[np.int64]
    distance_along: Array  # [m]
    force: Array  # [N] measured and filtered
    force_threshold: Array  # [N]
    period_deviation_p99: Array  # [s]


class Contacts(NamedTuple):
    """The simulated truth about brush and skin over time; N samples."""

    time: Array  # [s], shape (N,)
    T_base_head: Array  # shape (N, 4, 4)
    compression: Array  # [m], shape (N,)
    force: Array  # [N] resultant, shape (N,)
    part: NDArray[np.str_]  # skin class under the brush, shape (N,)


class PlannedPath(NamedTuple):
    """The poses of one path as they were sent to the arm; M poses."""

    path_id: int
    region: str
    T_base_head: Array  # shape (M, 4, 4)
    segment: NDArray[np.int64]  # index of the segment of each pose, shape (M,)
    complete: bool  # the last segment was sent


class TargetSeen(NamedTuple):
    """One contact target."""

    time: float  # [s] stamp of its colour picture
    region: str
    pixel: Array  # [px] (u, v), shape (2,)
    position: Array  # [m] in the base frame, shape (3,)


class Run(NamedTuple):
    """All of one bag."""

    arm: ArmStates
    contacts: Contacts
    paths: list[PlannedPath]
    targets: list[TargetSeen]
    planned_poses: int  # poses of the longest path that was announced, sent to the arm or not


def _arm_states(entries: Iterable[Entry]) -> ArmStates:
    rows = [
        (stamp_seconds(m.header.stamp), m.state, m.path_id, m.distance_along, m.force, m.force_threshold,
         m.period_deviation_p99)
        for m in (entry.message for entry in entries)
    ]  # fmt: skip
    time, state, path_id, *rest = np.array(rows, dtype=float).reshape(-1, 7).T
    return ArmStates(time, state.astype(int), path_id.astype(int), *rest)


def _contacts(entries: Iterable[Entry]) -> Contacts:
    messages = [entry.message for entry in entries]
    force = [np.linalg.norm([m.force.x, m.force.y, m.force.z]) for m in messages]
    return Contacts(
        np.array([stamp_seconds(m.header.stamp) for m in messages]),
        transforms_from_poses([message.head for message in messages]),
        np.array([m.compression for m in messages]),
        np.array(force, dtype=float),
        np.array([m.part for m in messages], dtype=np.str_),
    )


def _paths(entries: Iterable[Entry]) -> list[PlannedPath]:
    segments: dict[int, dict[int, Any]] = {}
    for entry in entries:
        segments.setdefault(entry.message.path_id, {})[entry.message.index] = entry.message
    paths = []
    for path_id, parts in segments.items():
        ordered = [parts[index] for index in sorted(parts)]
        matrices = transforms_from_poses([pose for part in ordered for pose in part.poses])
        index = [part.index for part in ordered for _ in part.poses]
        paths.append(PlannedPath(path_id, ordered[0].region, matrices, np.array(index), ordered[-1].last))
    return paths


def _targets(entries: Iterable[Entry]) -> list[TargetSeen]:
    return [
        TargetSeen(
            stamp_seconds(entry.message.header.stamp),
            target.region,
            np.array(target.pixel, dtype=float),
            transform_from_pose(target.pose.pose)[:3, 3],
        )
        for entry in entries
        for target in entry.message.targets
    ]


def read_run(bag: Path) -> Run:
    """Read what a run left behind; topics that are missing give empty arrays.

    Raises:
        BagError: When the bag cannot be read.
    """
    readers = {
        "arm_state": _arm_states,
        "sim_contact": _contacts,
        "scrub_segments": _paths,
        "contact_targets": _targets,
        "planned_path": lambda found: max((len(entry.message.poses) for entry in found), default=0),
    }
    entries: dict[str, list[Entry]] = {name: [] for name in readers}
    for entry in read_messages(bag, tuple(readers)):
        entries[entry.topic.rpartition("/")[2]].append(entry)
    return Run(*(reader(entries[name]) for name, reader in readers.items()))
