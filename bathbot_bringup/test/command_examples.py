"""One good request for every command of the emulated controller, and a desk to put it on."""

import numpy as np
from bathbot_bringup.sim.arm import commands  # noqa: F401 - fills the table
from bathbot_bringup.sim.arm.commands.table import Desk
from bathbot_bringup.sim.arm.controller.arm_setup import Arm
from bathbot_bringup.sim.arm.controller.controller import STEP, Controller
from bathbot_bringup.sim.arm.emulator.surface import NoSurface
from bathbot_bringup.sim.brush import Brush
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.protocol import joints_to_wire, pose_to_wire

READY = np.radians([0.0, 20.0, -100.0, 0.0, -60.0, 0.0])
JOINTS = joints_to_wire(READY)
PLACE = RM65("6F").flange(READY)


def place(x=0.0, y=0.0, z=0.0):
    """Pose on the wire, moved from READY [m]."""
    T = PLACE.copy()
    T[:3, 3] += (x, y, z)
    return pose_to_wire(T)


def desk_at(joints=READY, surface=None, generation=4, clock=lambda: 0.0):
    """A controller without wire."""
    arm = Arm(RM65("6F"), RM65_LIMITS, Brush(), generation)
    return Desk(Controller(arm, joints, surface or NoSurface(), clock, np.random.default_rng(0)))


def run(desk, seconds):
    """Step; give joints and speeds after every step, and the ends of motions."""
    joints, speeds, ends = [], [], []
    for _ in range(round(seconds / STEP)):
        ends += desk.controller.step()
        joints.append(desk.controller.dynamics.joints)
        speeds.append(desk.controller.dynamics.speeds[:])
    return np.array(joints), np.array(speeds), ends


_MOVE = {"v": 50, "r": 0, "trajectory_connect": 0}
_TOOL = {
    "tool_name": "brush",
    "payload": 350,
    "position": [0, 0, 50000],
    "tool_pose": [0, 0, 100000, 0, 0, 0],
}
_WORK = {"frame_name": "bath", "frame_pose": [100000, 0, 0, 0, 0, 0]}
_FORCE = {"sensor": 1, "mode": 1, "control_mode": [3, 3, 4, 3, 3, 3], "desired_force": [0, 0, 20, 0, 0, 0],
          "limit_vel": [100, 100, 100, 1000, 1000, 1000]}  # fmt: skip
_QUERIES = (
    "get_arm_software_info", "get_current_arm_state", "get_joint_degree", "get_arm_all_state",
    "get_controller_state", "get_current_joint_temperature", "get_current_joint_current",
    "get_current_joint_voltage", "get_joint_err_flag", "get_joint_en_state", "get_joint_min_pos",
    "get_joint_max_pos", "get_joint_max_speed", "get_joint_max_acc", "get_joint_drive_max_speed",
    "get_joint_drive_max_acc", "get_joint_drive_min_pos", "get_joint_drive_max_pos",
    "get_arm_max_line_speed", "get_arm_max_line_acc", "get_arm_max_angular_speed", "get_arm_max_angular_acc",
    "get_arm_power_state", "get_collision_stage", "get_arm_run_mode", "get_DH_data", "get_current_tool_frame",
    "get_current_work_frame", "get_total_tool_frame", "get_total_work_frame", "get_install_pose",
    "get_init_pose", "get_joint_software_version", "get_tool_software_version", "get_arm_current_trajectory",
    "get_system_runtime", "get_joint_odom", "get_self_collision_enable", "get_force_data",
    "get_realtime_push",
)  # fmt: skip
_PLAIN = ("set_arm_init", "clear_system_err", "set_stop_teach", "set_arm_stop", "set_arm_slow_stop",
          "set_arm_pause", "set_arm_continue", "clear_force_data", "set_force_sensor",
          "stop_set_force_sensor", "stop_force_position", "Start_Force_Position_Move",
          "Stop_Force_Position_Move")  # fmt: skip
_WITH_FIELDS = {
    "get_tool_frame": {"tool_name": "Arm_Tip"},
    "get_work_frame": {"frame_name": "Base"},
    "set_joint_en_state": {"joint_en_state": [1, 1]},
    "set_joint_max_speed": {"joint_max_speed": [1, 20000]},
    "set_joint_max_acc": {"joint_max_acc": [1, 50000]},
    "set_joint_min_pos": {"joint_min_pos": [1, -170000]},
    "set_joint_max_pos": {"joint_max_pos": [1, 170000]},
    "set_joint_clear_err": {"joint_clear_err": 1},
    "set_arm_max_line_speed": {"arm_line_speed": 200},
    "set_arm_max_line_acc": {"arm_line_acc": 1000},
    "set_arm_max_angular_speed": {"arm_angular_speed": 500},
    "set_arm_max_angular_acc": {"arm_angular_acc": 3000},
    "set_arm_power": {"arm_power": 1},
    "set_collision_stage": {"collision_stage": 3},
    "set_arm_run_mode": {"mode": 0},
    "set_manual_tool_frame": _TOOL,
    "update_tool_frame": _TOOL,
    "set_change_tool_frame": {"tool_name": "Arm_Tip"},
    "set_delete_tool_frame": {"tool_name": "brush"},
    "set_manual_work_frame": _WORK,
    "update_work_frame": _WORK,
    "set_change_work_frame": {"frame_name": "Base"},
    "set_delete_work_frame": {"frame_name": "bath"},
    "set_install_pose": {"pose": [0, 90, 0]},
    "set_init_pose": {"init_pose": JOINTS},
    "set_self_collision_enable": {"set_enable": True},
    "movej": {**_MOVE, "joint": [5000, *JOINTS[1:]]},
    "movej_p": {**_MOVE, "pose": place(y=0.02)},
    "movel": {**_MOVE, "pose": place(y=0.02)},
    "movel_offset": {**_MOVE, "offset": [0, 20000, 0, 0, 0, 0], "frame_type": 0},
    "movec": {**_MOVE, "pose": {"pose_via": place(y=0.02, z=0.02), "pose_to": place(y=0.04)}, "loop": 0},
    "moves": {**_MOVE, "pose": place(y=0.02)},
    "set_joint_step": {"joint_step": [1, 3000], "v": 50},
    "set_pos_step": {"step_type": "z_step", "step": 10000, "v": 50},
    "set_ort_step": {"step_type": "rz_step", "step": 50, "v": 50},
    "set_joint_teach": {"teach_joint": 1, "direction": "pos", "v": 10},
    "set_pos_teach": {"teach_type": "z", "direction": "neg", "v": 10},
    "set_ort_teach": {"teach_type": "rz", "direction": "pos", "v": 10},
    "movej_canfd": {"joint": [500, *JOINTS[1:]], "follow": True, "expand": 0, "trajectory_mode": 0,
                    "radio": 0},
    "movep_canfd": {"pose": place(y=0.002), "follow": True, "trajectory_mode": 2, "radio": 50},
    "movej_follow": {"joint": [5000, *JOINTS[1:]]},
    "movep_follow": {"pose": place(y=0.02)},
    "set_movev_canfd_init": {"avoid_singularity_flag": 0, "frame_type": 1, "dt": 10},
    "movev_canfd": {"cartesian_velocity": [0, 20000, 0, 0, 0, 0], "follow": True},
    "set_delete_current_trajectory": {},
    "set_arm_delete_trajectory": {},
    "set_arm_emergency_stop": {"emergency_stop": 0},
    **{f"manual_set_force_pose{number}": {"joint": JOINTS} for number in (1, 2, 3, 4)},
    "set_force_position": _FORCE,
    "Force_Position_Move": {**_FORCE, "joint": JOINTS, "follow": True},
    "set_realtime_push": {"cycle": 2, "enable": True, "port": 8089, "force_coordinate": 2, "ip": "127.0.0.1",
                          "custom": {"joint_speed": False}},
}  # fmt: skip
_BARE: dict[str, dict] = {key: {} for key in _QUERIES + _PLAIN}
EXAMPLES = {name: {"command": name, **fields} for name, fields in {**_BARE, **_WITH_FIELDS}.items()}
