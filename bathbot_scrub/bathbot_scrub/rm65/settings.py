"""What a user may change of the arm driver; `config/rm65_driver.yaml` has these keys."""

import math
from dataclasses import dataclass, field
from typing import Any

from bathbot_localize.arm.scrub_head import SCRUB_HEAD

from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS
from bathbot_scrub.rm65.arm.limits import HOME_DEG, RM65_LIMITS
from bathbot_scrub.rm65.arm.walls import walls_from
from bathbot_scrub.rm65.errors import ArmSettingsError


def _about(default: Any, text: str) -> Any:
    return field(default=default, metadata={"help": text})


@dataclass(frozen=True, slots=True)
class DriverSettings:
    """Parameters of the driver, SI units unless the name says otherwise."""

    host: str = _about("127.0.0.1", "address of the controller; 192.168.1.18 on a new arm")
    port: int = _about(8080, "TCP port of the controller")
    udp_port: int = _about(8089, "our UDP port for the state push; 0: any free one")
    variant: str = _about("6F", "RM65 variant: B, 6F (sensor as extra part) or 6FB (sensor built in)")
    force_limits: str = _about("", "file of force limits; empty: config/force_limits.yaml")

    rate: float = _about(100.0, "of joint commands [Hz]; the controller's high-follow mode needs 100 or more")
    home_deg: tuple[float, ...] = _about(HOME_DEG, "folded posture out of the view [deg]")
    joint_speed: float = _about(0.8, "of the fastest joint between postures [rad/s]")
    joint_acceleration: float = _about(2.0, "of the fastest joint between postures [rad/s^2]")
    joint_share: float = _about(0.5, "of the joints' limits that tool paths may use, 0..1")

    standoff: float = _about(0.06, "distance to the target at which the straight part begins [m]")
    approach_speed: float = _about(0.03, "of the straight part [m/s]")
    max_extra: float = _about(0.012, "beyond the target after which no contact is an error [m]")
    scrub_acceleration: float = _about(0.3, "along scrub paths [m/s^2]")
    max_scrub_speed: float = _about(0.10, "segments may ask for less, never for more [m/s]")
    lift: float = _about(0.03, "clear of the skin when a path begins elsewhere [m]")
    max_lead_in: float = _about(0.35, "between the head and the first pose of a path [m]")
    queue_length: int = _about(64, "segments that may wait, the one under the head included")

    walls: tuple[float, ...] = _about(
        (0.0, 0.0, 1.0, -0.75, 1.0, 0.0, 0.0, -0.75),
        "no link passes these planes, four numbers each: normal into the room, offset [m]",
    )
    body_margin: float = _about(0.015, "between links and what the camera sees, outside the patch washed [m]")
    scrub_margin: float = _about(0.005, "the same along scrub paths, which are slow [m]")
    body_max_age: float = _about(5.0, "of body_cloud; with an older one no way leads to the person [s]")

    retract_distance: float = _about(0.10, "along the outward normal [m]")
    retract_speed: float = _about(0.25, "faster than a body moves towards the arm [m/s]")
    home_needs_consent: bool = _about(
        True, "after a retract that force demanded, home and approach wait for arm/resume"
    )

    brake_after: float = _about(0.05, "without a readable sample the arm brakes and waits [s]")
    stale_after: float = _about(0.3, "without one it waits no more: FAULT [s]")
    steady_for: float = _about(0.3, "data must have come without a gap before the arm goes on by itself [s]")
    wait_at_most: float = _about(2.0, "for data that come and go; then FAULT [s]")
    frozen_samples: int = _about(12, "readings of the force in a row that came before; noise never repeats")
    following_tolerance: float = _about(0.005, "that a joint may be off all it was told lately [rad]")
    following_after: float = _about(0.02, "for which it may be farther off than that [s]")
    still_tolerance: float = _about(0.0015, "that a joint may be told to go without moving [rad]")
    deaf_after: float = _about(0.06, "without answer to a question over TCP the arm brakes and waits [s]")
    leave_after: float = _about(10.0, "on the skin without any motion; then the arm leaves it [s]")

    tool_mass: float = _about(
        0.0, "of the tool, as far as the controller's own calibration leaves it out [kg]"
    )
    tool_centre: tuple[float, ...] = _about(
        (0.0, 0.0, SCRUB_HEAD.mass_centre), "its centre, from the flange [m]"
    )
    force_cutoff: float = _about(15.0, "of the low-pass on the wrench [Hz]")
    publish_rate: float = _about(50.0, "of joint_states, wrench and tool_pose [Hz]")
    vendor_topics: bool = _about(False, "also offer the topics of the vendor's driver, under rm_driver/")

    def __post_init__(self) -> None:
        """Refuse values no arm can meet."""
        if self.variant not in FLANGE_OFFSETS:
            raise ArmSettingsError(f"unknown variant {self.variant!r}; known are {', '.join(FLANGE_OFFSETS)}")
        if not self.host:
            raise ArmSettingsError("host is empty; give the address of the controller")
        for name, lowest in (("port", 1), ("udp_port", 0)):
            if not lowest <= getattr(self, name) <= 65535:
                raise ArmSettingsError(f"{name} must be {lowest}..65535, got {getattr(self, name)}")
        for name in (
            "joint_speed",
            "joint_acceleration",
            "standoff",
            "approach_speed",
            "max_extra",
            "scrub_acceleration",
            "max_scrub_speed",
            "lift",
            "max_lead_in",
            "body_margin",
            "scrub_margin",
            "body_max_age",
            "retract_distance",
            "retract_speed",
            "brake_after",
            "stale_after",
            "steady_for",
            "wait_at_most",
            "following_tolerance",
            "following_after",
            "still_tolerance",
            "deaf_after",
            "leave_after",
            "force_cutoff",
            "publish_rate",
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ArmSettingsError(f"{name} must be positive and finite, got {value}")
        if not 100.0 <= self.rate <= 500.0:
            raise ArmSettingsError(f"rate must be 100..500 Hz for high-follow streaming, got {self.rate}")
        if not 0.0 < self.joint_share <= 1.0:
            raise ArmSettingsError(f"joint_share must lie in 0..1, got {self.joint_share}")
        if self.queue_length < 2:
            raise ArmSettingsError(f"queue_length must be 2 or more, got {self.queue_length}")
        if not self.brake_after < self.stale_after <= self.wait_at_most:
            raise ArmSettingsError(
                "need brake_after < stale_after <= wait_at_most, got "
                f"{self.brake_after}, {self.stale_after} and {self.wait_at_most} s"
            )
        if self.frozen_samples < 3:
            raise ArmSettingsError(f"frozen_samples must be 3 or more, got {self.frozen_samples}")
        if not (0.0 <= self.tool_mass <= 5.0 and len(self.tool_centre) == 3):
            raise ArmSettingsError(
                f"tool_mass must be 0..5 kg and tool_centre three lengths, got {self.tool_mass} "
                f"and {self.tool_centre}"
            )
        if len(self.home_deg) != 6:
            raise ArmSettingsError(f"home_deg must be six angles, got {self.home_deg}")
        walls_from(self.walls)
        RM65_LIMITS.check([math.radians(angle) for angle in self.home_deg])
