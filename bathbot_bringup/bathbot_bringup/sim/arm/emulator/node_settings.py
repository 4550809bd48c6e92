"""What a user may change of the simulated arm; `config/sim_rm65.yaml` has these keys."""

from dataclasses import dataclass, field
from typing import Any

from bathbot_scrub.rm65.arm.limits import HOME_DEG

from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_bringup.sim.scenario import Scenario, load_scenario


def _about(default: Any, text: str) -> Any:
    return field(default=default, metadata={"help": text})


@dataclass(frozen=True, slots=True)
class SimRm65Settings:
    """Parameters of the emulated controller and of the person it may touch."""

    host: str = _about("127.0.0.1", "address to listen on; loopback unless told otherwise")
    port: int = _about(8080, "TCP port; 0: any free one")
    udp_port: int = _about(8089, "where the state push goes until a client sets it")
    variant: str = _about("6F", "RM65 variant: B, 6F or 6FB")
    generation: int = _about(3, "of the controller: 3 or 4")
    joints_deg: tuple[float, ...] = _about(HOME_DEG, "where the arm stands at first [deg]")
    seed: int = _about(0, "of the person and of the sensor's noise; as in sim_camera")
    scenario: str = _about("calm", "name or YAML file of how the person moves; as in sim_camera")
    person: bool = _about(True, "false: nobody there, the brush meets nothing")
    epoch: float = _about(
        0.0, "ROS time at which the person's motion begins [s], shared with sim_camera; 0: now"
    )
    trace: str = _about("", "file to write what really happened to, .npz, at the end; empty: none")

    def __post_init__(self) -> None:
        """Refuse what no controller has."""
        self.emulator()
        if self.seed < 0:
            raise SettingsError(f"seed must not be negative, got {self.seed}")
        if not self.epoch >= 0.0:
            raise SettingsError(f"epoch must be a time in s or 0, got {self.epoch}")
        if self.trace and not self.trace.endswith(".npz"):
            raise SettingsError(f"trace must be an .npz file, got {self.trace}")
        self.motion()

    def emulator(self) -> EmulatorSettings:
        """The part about the controller."""
        return EmulatorSettings(
            self.host, self.port, self.udp_port, self.variant, self.generation, self.seed, self.joints_deg
        )

    def motion(self) -> Scenario:
        """How the person moves."""
        return load_scenario(self.scenario)
