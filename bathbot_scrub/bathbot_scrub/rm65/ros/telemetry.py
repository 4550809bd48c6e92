"""What the driver tells all the time: joints, wrenches, pose, frames, state. Takes publishers, no node."""

from typing import Any, NamedTuple, Protocol

from bathbot_scrub.arm.states import Reaction, State
from bathbot_scrub.rm65.driver import ArmDriver, Snapshot
from bathbot_scrub.rm65.guard.force_checks import comfort
from bathbot_scrub.rm65.guard.watchdogs import UNSTEADY, WATCHDOGS, gravest
from bathbot_scrub.rm65.ros.messages import (
    arm_state_message,
    joint_state_message,
    pose_stamped,
    stamp_of,
    tree_message,
    wrench_message,
)

_TREE_RATE, _STATE_RATE = 50.0, 20.0  # [Hz]


class Publisher(Protocol):
    """Anything that sends messages."""

    def publish(self, message: Any) -> None:
        """Send one."""


class Publishers(NamedTuple):
    """One for each topic."""

    joints: Publisher
    wrench: Publisher
    filtered: Publisher
    pose: Publisher
    tree: Publisher
    state: Publisher


class Telemetry:
    """Publishes the newest sample of a driver whenever it is called, its state less often."""

    def __init__(self, driver: ArmDriver, publishers: Publishers) -> None:
        """Tell of `driver` through `publishers`."""
        self._driver, self._publishers = driver, publishers
        rate = driver.settings.publish_rate
        self._tree_every, self._state_every = (
            max(int(rate / wanted), 1) for wanted in (_TREE_RATE, _STATE_RATE)
        )
        self._calls, self._shown = 0, (State.FREE, "")

    def publish(self, now: Any) -> Snapshot | None:
        """Publish what is due; `now` is ROS time. Gives the state when that was due, as at every change."""
        self._calls += 1
        sample, wrench, publishers = self._driver.link.sample, self._driver.link.wrench, self._publishers
        stamp = now if sample is None else stamp_of(sample.stamp, now)
        if sample is not None and wrench is not None:
            publishers.joints.publish(joint_state_message(sample.joints, stamp))
            publishers.wrench.publish(wrench_message(wrench.raw, stamp))
            publishers.filtered.publish(wrench_message(wrench.filtered, stamp))
            publishers.pose.publish(pose_stamped(self._driver.arm.head(sample.joints), stamp))
            if self._calls % self._tree_every == 0:
                publishers.tree.publish(tree_message(self._driver.arm, sample.joints, stamp))
        guard = self._driver.loop.guard
        if self._calls % self._state_every and (guard.state, guard.reason) == self._shown:
            return None
        self._shown = (guard.state, guard.reason)
        snapshot = self._driver.snapshot()
        publishers.state.publish(arm_state_message(snapshot, stamp))
        return snapshot


def diagnostic_values(driver: ArmDriver, snapshot: Snapshot) -> dict[str, Any]:
    """What a person who looks for a fault wants to know; one key for each watchdog."""
    loop, counts = driver.loop, driver.link.counts()
    said = {alarm.name: alarm.message for alarm in loop.alarms}
    return {
        "state": snapshot.state.name,
        "connected": snapshot.connected,
        "force": f"{snapshot.force:.2f}",
        "comfort": comfort_word(driver, snapshot) or "ok",
        "body": driver.surroundings.status(),
        "samples": counts.samples,
        "samples_refused": counts.samples_refused,
        "protocol_errors": counts.protocol_errors,
        "commands": loop.log.statistics.sent,
        "periods_missed": loop.log.statistics.missed,
        "period_deviation_p99_ms": f"{snapshot.period_deviation_p99 * 1e3:.3f}",
        "period_ms_max": f"{loop.log.statistics.longest * 1e3:.1f}",
        "reactions": loop.log.reactions.count,
        "reaction_ms_p99": f"{loop.log.reactions.p99() * 1e3:.1f}",
        "reaction_ms_max": f"{loop.log.reactions.longest * 1e3:.1f}",
        "priority": loop.thread.priority,
        **{name: said.get(name, "ok") for name in (*(dog.name for dog in WATCHDOGS), UNSTEADY)},
    }


class Health(NamedTuple):
    """How the driver does, for its diagnostic."""

    sound: bool  # in touch with the controller, and in no FAULT
    doubtful: bool  # there is something that does not stop the arm but that a person should know
    message: str


def health(driver: ArmDriver, snapshot: Snapshot, refused: str) -> Health:
    """Sum up; `refused` says why the newest segment was not taken, empty when it was."""
    sound = snapshot.connected and snapshot.state is not State.FAULT
    doubt = refused or warning(driver, snapshot)
    return Health(sound, bool(doubt), refused or snapshot.reason or doubt or snapshot.state.name)


def comfort_word(driver: ArmDriver, snapshot: Snapshot) -> str:
    """What the comfort band says of the force while the head scrubs; empty when nothing."""
    guard = driver.loop.guard
    scrubbing = snapshot.state is State.CONTACT and driver.loop.moving
    return comfort(snapshot.force, guard.region).word if scrubbing else ""


def warning(driver: ArmDriver, snapshot: Snapshot) -> str:
    """The gravest thing that does not stop the arm but that a person should know; empty when nothing."""
    alarm = gravest(driver.loop.alarms)
    return alarm.message if alarm.reaction is not Reaction.NONE else comfort_word(driver, snapshot)
