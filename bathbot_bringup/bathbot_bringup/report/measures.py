"""All numbers of one bathing run, from its bag and the simulated truth."""

from typing import NamedTuple

import numpy as np
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import State
from numpy.typing import NDArray

from bathbot_bringup.report.contact_measures import ContactMeasures, contact_measures, in_contact
from bathbot_bringup.report.coverage import Coverage, coverage
from bathbot_bringup.report.path_error import PathError, path_error
from bathbot_bringup.report.run_data import PlannedPath, Run
from bathbot_bringup.report.truth import Truth

Array = NDArray[np.float64]


class RunMeasures(NamedTuple):
    """What is shown in the report.

    Attributes:
        path: The path that was scrubbed; None when none was planned.
        error: Deviations from it.
        contact: Contact and forces.
        coverage: Skin under the brush.
        target_errors: Found minus true position of every target of the region [m], shape (T, 3).
        target_times: Of the same [s], shape (T,).
        force_threshold: Above which the arm would have retracted [N]; NaN when it never said.
        period_deviation: 99th percentile of the deviation of the command period [s]; NaN likewise.
    """

    path: PlannedPath | None
    error: PathError
    contact: ContactMeasures
    coverage: Coverage
    target_errors: Array
    target_times: Array
    force_threshold: float
    period_deviation: float


def measure_run(run: Run, truth: Truth, region: str) -> RunMeasures:
    """Work all of it out.

    Args:
        run: Read from the bag.
        truth: Of the same seed, scenario and epoch.
        region: Full name of the region that was asked for.
    """
    contacts, arm = run.contacts, run.arm
    path = max(run.paths, key=lambda entry: len(entry.T_base_head), default=None)
    poses = path.T_base_head if path is not None else np.zeros((0, 4, 4))
    during = _during(run, path)
    along = np.interp(contacts.time[during], arm.time, arm.distance_along)
    error = path_error(poses, contacts.time[during], contacts.T_base_head[during, :3, 3], along)
    targets = [target for target in run.targets if target.region == region]
    busy = np.isin(arm.state, (State.APPROACH, State.CONTACT, State.RETRACTING))
    return RunMeasures(
        path,
        error,
        contact_measures(
            _with_unsent(error.time, run),
            contacts.time,
            contacts.compression,
            contacts.force,
            shipped_force_limits().region(region).comfort,
        ),
        _covered(run, truth, region, poses, error),
        np.array([truth.target_error(target) for target in targets]).reshape(-1, 3),
        np.array([target.time for target in targets]),
        _least(arm.force_threshold[arm.state == State.CONTACT]),
        float(np.max(arm.period_deviation_p99[busy])) if busy.any() else np.nan,
    )


def _with_unsent(passed: Array, run: Run) -> Array:
    """Add the poses that were planned and never sent: the head did not pass them."""
    return np.concatenate([passed, np.full(max(run.planned_poses - len(passed), 0), np.nan)])


def _during(run: Run, path: PlannedPath | None) -> NDArray[np.bool_]:
    """Tell which contact samples fall into the time on the path, without the way to its first pose."""
    arm, time = run.arm, run.contacts.time
    following = (arm.state == State.CONTACT) & (arm.path_id == (path.path_id if path is not None else -1))
    on_path = np.flatnonzero(following & (arm.distance_along > 0.0))
    if not len(on_path):
        return np.zeros(len(time), dtype=bool)
    begin = arm.time[max(on_path[0] - 1, 0)]  # the last report before it moved on along the path
    return (time >= begin) & (time <= arm.time[following][-1])


def _covered(run: Run, truth: Truth, region: str, poses: Array, error: PathError) -> Coverage:
    """Coverage by the moments on the path in which the bristles were bent."""
    contacts = run.contacts
    touching = in_contact(contacts.time, contacts.time, contacts.compression)
    if error.passed.any():
        touching &= (contacts.time >= np.nanmin(error.time)) & (contacts.time <= np.nanmax(error.time))
    heads = contacts.T_base_head[touching]
    tips = heads[:, :3, 3] - contacts.compression[touching, None] * heads[:, :3, 2]
    return coverage(
        poses, truth.surface.faces, truth.skin_faces(region), truth.vertices, contacts.time[touching], tips
    )


def _least(values: Array) -> float:
    positive = values[values > 0.0]
    return float(positive.min()) if len(positive) else np.nan
