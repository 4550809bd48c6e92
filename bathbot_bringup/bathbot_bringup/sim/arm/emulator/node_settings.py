"""What a user may change of the simulated arm; `config/sim_rm65.yaml` has these keys."""

from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import check, same, setting

from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_bringup.sim.scenario import Scenario, load_scenario


@dataclass(frozen=True, slots=True)
class SimRm65Settings:
    """Parameters of the emulated controller and of the person it may touch."""

    host: str = same(EmulatorSettings, "host")
    port: int = same(EmulatorSettings, "port")
    udp_port: int = same(EmulatorSettings, "udp_port")
    variant: str = same(EmulatorSettings, "variant")
    generation: int = same(EmulatorSettings, "generation")
    joints_deg: tuple[float, ...] = same(EmulatorSettings, "joints_deg")
    seed: int = setting(
        0, "Seed of the person and of the force sensor's noise; the same as that of sim_camera", low=0
    )
    scenario: str = setting(
        "calm", "How the person moves: a name or a YAML file; the same as that of sim_camera"
    )
    person: bool = setting(True, "Whether a person is there; without one the brush meets nothing")
    epoch: float = setting(
        0.0, "ROS time at which the person's motion begins, the same as that of sim_camera; 0: when the "
        "node starts", "s", low=0.0,
    )  # fmt: skip
    trace: str = setting(
        "", "File, ending in .npz, to which what really happened to the arm is written at the end; empty: "
        "none",
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what no controller has.

        Raises:
            BathbotError: With the value and what is allowed.
        """
        check(self, SettingsError)
        self.emulator()
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
