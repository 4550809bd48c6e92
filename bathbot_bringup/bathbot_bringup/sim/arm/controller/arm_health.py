"""Power, brakes and errors of the emulated arm."""

from bathbot_bringup.sim.faults.joint_faults import COLLISION, JOINT_DISABLED, JointTrouble

TARGET_OVER_LIMIT, UNREACHABLE, OVER_SPEED, ARC_IMPOSSIBLE = 0x1002, 0x1003, 0x1009, 0x1011
_TRIPS = (COLLISION, JOINT_DISABLED)
_ALL_JOINTS = frozenset(range(6))


class ArmHealth:
    """What keeps the arm from moving. Codes are those of the controller; 0 is none."""

    def __init__(self) -> None:
        """Switch everything on."""
        self.power, self.emergency = True, False
        self.enabled = [True] * 6  # joints that a client has not switched off
        self.error, self.joint_codes = 0, [0] * 6

    @property
    def tripped(self) -> bool:
        """Whether a fault of the arm keeps the stream from being obeyed, until errors are cleared."""
        return self.error in _TRIPS

    @property
    def ready(self) -> bool:
        """Whether the arm may move at all."""
        return self.power and not self.emergency and all(self.enabled)

    @property
    def joints_on(self) -> list[int]:
        """Which joints are switched on and well, 1 or 0 each."""
        held = self.braked
        return [int(joint not in held and not code) for joint, code in enumerate(self.joint_codes)]

    @property
    def braked(self) -> frozenset[int]:
        """Joints, from 0, that are held by their brakes."""
        if not self.power or self.emergency:
            return _ALL_JOINTS
        return frozenset(joint for joint, on in enumerate(self.enabled) if not on)

    def note(self, trouble: JointTrouble) -> None:
        """Keep the codes of what is wrong."""
        self.error = trouble.error
        if trouble.code:
            self.joint_codes[trouble.joint] = trouble.code

    def clear(self) -> None:
        """Forget errors; what still lasts raises them again."""
        self.error, self.joint_codes = 0, [0] * 6

    def clear_joint(self, joint: int) -> None:
        """Forget the error of one joint, from 0, and the arm's if that was all."""
        self.joint_codes[joint] = 0
        if self.error == JOINT_DISABLED and not any(self.joint_codes):
            self.error = 0
