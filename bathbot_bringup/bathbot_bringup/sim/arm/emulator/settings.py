"""What a user may change about the emulated controller."""

from dataclasses import dataclass

from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS
from bathbot_scrub.rm65.arm.limits import HOME_DEG
from bathbot_scrub.rm65.errors import ArmSettingsError


@dataclass(frozen=True, slots=True)
class EmulatorSettings:
    """Where the emulator listens and which arm it is."""

    host: str = "127.0.0.1"  # loopback unless told otherwise
    port: int = 8080  # TCP; 0: any free one
    udp_port: int = 8089  # where the state push goes until a client sets it
    variant: str = "6F"
    generation: int = 3
    seed: int = 0  # of the force sensor's noise
    joints_deg: tuple[float, ...] = HOME_DEG  # where the arm stands at first

    def __post_init__(self) -> None:
        """Refuse what no controller has."""
        if not self.host.strip():
            raise ArmSettingsError("host must not be empty; 127.0.0.1 hears only this machine, 0.0.0.0 all")
        for name, lowest in (("port", 0), ("udp_port", 1)):
            if not lowest <= getattr(self, name) <= 65535:
                raise ArmSettingsError(f"{name} must be {lowest}..65535, got {getattr(self, name)}")
        if self.variant not in FLANGE_OFFSETS:
            raise ArmSettingsError(f"unknown variant {self.variant!r}; known are {', '.join(FLANGE_OFFSETS)}")
        if self.generation not in (3, 4):
            raise ArmSettingsError(f"generation must be 3 or 4, got {self.generation}")
        if len(self.joints_deg) != 6:
            raise ArmSettingsError(f"joints_deg must be six angles, got {self.joints_deg}")
