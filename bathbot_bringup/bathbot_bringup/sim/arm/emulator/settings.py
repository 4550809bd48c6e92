"""What a user may change about the emulated controller."""

from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, setting
from bathbot_scrub.arm.errors import ArmSettingsError
from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS
from bathbot_scrub.rm65.arm.limits import HOME_DEG


@dataclass(frozen=True, slots=True)
class EmulatorSettings:
    """Where the emulator listens and which arm it is."""

    host: str = setting(
        "127.0.0.1", "Network address to listen on; 127.0.0.1 hears only this machine, 0.0.0.0 all"
    )
    port: int = setting(8080, "TCP port to listen on; 0: any free one", low=0, high=65535)
    udp_port: int = setting(
        8089, "UDP port to which the arm's state is pushed until a client sets another", low=1, high=65535
    )
    variant: str = setting(
        "6F", "Variant of the RM65: B, 6F (force sensor as extra part) or 6FB (force sensor built in)",
        choices=tuple(FLANGE_OFFSETS),
    )  # fmt: skip
    generation: int = setting(3, "Generation of the controller that is emulated", choices=(3, 4))
    seed: int = setting(0, "Seed of the force sensor's noise")
    joints_deg: tuple[float, ...] = setting(
        HOME_DEG, "Angles of the six joints in which the arm stands at first", "deg", length=6
    )

    def __post_init__(self) -> None:
        """Refuse what no controller has.

        Raises:
            ArmSettingsError: With the value and what is allowed.
        """
        check(self, ArmSettingsError)
        if not self.host.strip():
            raise ArmSettingsError("host must not be empty; 127.0.0.1 hears only this machine, 0.0.0.0 all")
