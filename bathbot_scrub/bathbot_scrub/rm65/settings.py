"""What a user may change of the arm driver; `config/rm65_driver.yaml` has these keys."""

import math
from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, setting
from bathbot_localize.arm.scrub_head import SCRUB_HEAD

from bathbot_scrub.arm.errors import ArmSettingsError
from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS
from bathbot_scrub.rm65.arm.limits import HOME_DEG, RM65_LIMITS
from bathbot_scrub.rm65.arm.walls import walls_from

LEAST_STANDOFF = 0.02  # [m] at which the fast way ends before the skin: twice the give of the bristles
FASTEST_APPROACH = 0.06  # [m/s] at which the search for skin was judged, Face included


@dataclass(frozen=True, slots=True)
class DriverSettings:
    """Parameters of the driver, SI units unless the name says otherwise; `docs/safety.md` explains bounds."""

    host: str = setting("127.0.0.1", "Network address of the arm's controller; 192.168.1.18 on a new arm")
    port: int = setting(8080, "TCP port of the arm's controller", low=1, high=65535)
    udp_port: int = setting(
        8089, "UDP port of this machine to which the controller pushes the arm's state; 0: any free one",
        low=0, high=65535,
    )  # fmt: skip
    variant: str = setting(
        "6F", "Variant of the RM65: B, 6F (force sensor as extra part) or 6FB (force sensor built in)",
        choices=tuple(FLANGE_OFFSETS),
    )  # fmt: skip
    force_limits: str = setting(
        "", "YAML file of force limits for each region of the body; empty: config/force_limits.yaml"
    )

    rate: float = setting(
        100.0, "Rate of the joint commands sent to the controller, whose high-follow mode needs 100 or "
        "more", "Hz", low=100.0, high=500.0,
    )  # fmt: skip
    home_deg: tuple[float, ...] = setting(
        HOME_DEG, "Angles of the six joints in the home posture, folded and out of the camera's view", "deg",
        length=6,
    )  # fmt: skip
    joint_speed: float = setting(
        0.8, "Speed of the fastest joint on the way between two postures", "rad/s", low=0.05, high=2.0
    )
    joint_acceleration: float = setting(
        2.0,
        "Acceleration of the fastest joint on the way between two postures",
        "rad/s^2",
        low=0.1,
        high=10.0,
    )
    joint_share: float = setting(
        0.5, "Share of the joints' speed and acceleration limits that paths of the scrub head may use, "
        "0..1", above=0.0, high=1.0,
    )  # fmt: skip

    standoff: float = setting(
        0.06,
        "Distance from the contact target at which the straight part of an approach begins",
        "m",
        low=LEAST_STANDOFF,
        high=0.3,
    )
    approach_speed: float = setting(
        0.03,
        "Speed of the scrub head on the straight part of an approach",
        "m/s",
        low=0.005,
        high=FASTEST_APPROACH,
    )
    max_extra: float = setting(
        0.012,
        "Distance beyond the contact target at which an approach without contact ends as an error",
        "m",
        low=0.002,
        high=0.02,
    )
    scrub_acceleration: float = setting(
        0.3, "Acceleration of the scrub head along scrub paths", "m/s^2", low=0.05, high=1.0
    )
    max_scrub_speed: float = setting(
        0.10,
        "Highest speed of the scrub head along scrub paths; segments may ask for less, never for more",
        "m/s",
        low=0.005,
        high=0.10,
    )
    lift: float = setting(
        0.03,
        "Distance by which the scrub head is lifted off the skin where a path begins elsewhere on it",
        "m",
        low=0.015,
        high=0.1,
    )
    max_lead_in: float = setting(
        0.35,
        "Largest distance of the first pose of a scrub path from where the scrub head is",
        "m",
        low=0.05,
        high=0.5,
    )
    queue_length: int = setting(
        64,
        "Number of segments that may wait in the driver, the one under the scrub head included",
        low=2,
        high=100,
    )

    walls: tuple[float, ...] = setting(
        (0.0, 0.0, 1.0, -0.75, 1.0, 0.0, 0.0, -0.75),
        "Planes of the base frame that no link of the arm passes, four numbers each: a normal that points "
        "into the room, and the plane's offset along it", "m",
    )  # fmt: skip
    body_margin: float = setting(
        0.015,
        "Distance that the arm's links keep from what the camera sees of the person, except near "
        "the patch that is washed",
        "m",
        low=0.01,
        high=0.1,
    )
    scrub_margin: float = setting(
        0.005,
        "Distance that the arm's links keep from the person along scrub paths, which are slow",
        "m",
        low=0.003,
        high=0.05,
    )
    body_max_age: float = setting(
        5.0,
        "Age of the newest body_cloud above which the arm takes no way to the person",
        "s",
        low=0.5,
        high=10.0,
    )

    retract_distance: float = setting(
        0.10,
        "Distance by which a retract takes the scrub head off the skin, along the skin's normal",
        "m",
        low=0.05,
        high=0.3,
    )
    retract_speed: float = setting(
        0.25,
        "Speed of the scrub head in a retract; faster than a body moves towards the arm",
        "m/s",
        low=0.15,
        high=0.5,
    )
    home_needs_consent: bool = setting(
        True, "Whether, after a retract that force demanded, going home and approaching wait for arm/resume"
    )

    brake_after: float = setting(
        0.05,
        "Age of the newest readable state of the arm above which the arm brakes and waits",
        "s",
        low=0.02,
        high=0.15,
    )
    stale_after: float = setting(
        0.3,
        "Age of the newest readable state of the arm above which the driver goes to FAULT",
        "s",
        low=0.05,
        high=2.0,
    )
    steady_for: float = setting(
        0.3,
        "Time for which states of the arm must have come without a gap before it goes on by itself",
        "s",
        low=0.1,
        high=5.0,
    )
    wait_at_most: float = setting(
        2.0,
        "Time for which the arm waits for data that come and go, before the driver goes to FAULT",
        "s",
        low=0.05,
        high=10.0,
    )
    frozen_samples: int = setting(
        12, "Number of equal readings of the force in a row that count as a frozen sensor; noise never "
        "repeats", low=3, high=24,
    )  # fmt: skip
    following_tolerance: float = setting(
        0.005,
        "Angle by which a joint may be off every position it was told lately",
        "rad",
        low=0.002,
        high=0.01,
    )
    following_after: float = setting(
        0.02,
        "Time for which a joint may be farther off than following_tolerance, before FAULT",
        "s",
        low=0.005,
        high=0.04,
    )
    still_tolerance: float = setting(
        0.0015,
        "Angle that a joint may be told to go without moving, before FAULT",
        "rad",
        low=0.0005,
        high=0.003,
    )
    deaf_after: float = setting(
        0.06,
        "Time without the controller's answer to a question over TCP after which the arm brakes and waits",
        "s",
        low=0.02,
        high=1.0,
    )
    leave_after: float = setting(
        10.0,
        "Time for which the scrub head may stand on the skin without any motion before it leaves it",
        "s",
        low=0.5,
        high=20.0,
    )

    tool_mass: float = setting(
        0.0, "Mass of the tool, as far as the controller's own calibration of the force sensor leaves it "
        "out", "kg", low=0.0, high=1.0,
    )  # fmt: skip
    tool_centre: tuple[float, ...] = setting(
        (0.0, 0.0, SCRUB_HEAD.mass_centre), "Centre of the tool's mass in the frame of the flange: x, y, z",
        "m", length=3, low=-0.3, high=0.3,
    )  # fmt: skip
    force_cutoff: float = setting(
        15.0, "Cut-off frequency of the low-pass filter on the wrench", "Hz", low=8.0, high=50.0
    )
    publish_rate: float = setting(
        50.0,
        "Rate at which joint_states, wrench, tool_pose and arm_state are published",
        "Hz",
        low=20.0,
        high=200.0,
    )
    vendor_topics: bool = setting(
        False, "Whether to offer the topics of the vendor's own driver as well, under rm_driver/"
    )

    def __post_init__(self) -> None:
        """Refuse values no arm can meet.

        Raises:
            ArmError: With the value and what is allowed.
        """
        check(self, ArmSettingsError)
        if not self.host:
            raise ArmSettingsError("host is empty; give the address of the controller")
        if not self.brake_after < self.stale_after <= self.wait_at_most:
            raise ArmSettingsError(
                "need brake_after < stale_after <= wait_at_most, got "
                f"{self.brake_after}, {self.stale_after} and {self.wait_at_most} s"
            )
        walls_from(self.walls)
        RM65_LIMITS.check([math.radians(angle) for angle in self.home_deg])
