"""One session of the vendor's own client against an emulator, as a process: it may hang, then it is ended.

    python vendor_session.py PORT UDP_PORT GENERATION

Prints one JSON object per call: {"call": name, "code": return code}.
"""

import json
import sys
import threading
import time

from Robotic_Arm.rm_robot_interface import (
    RoboticArm,
    rm_frame_t,
    rm_ort_teach_type_e,
    rm_pos_teach_type_e,
    rm_realtime_arm_state_callback_ptr,
    rm_realtime_push_config_t,
    rm_thread_mode_e,
)

READ = (
    "arm_software_info", "current_arm_state", "joint_degree", "arm_all_state", "controller_state",
    "current_joint_temperature", "current_joint_current", "current_joint_voltage", "joint_err_flag",
    "joint_en_state", "joint_min_pos", "joint_max_pos", "joint_max_speed", "joint_max_acc",
    "joint_drive_max_speed", "joint_drive_max_acc", "joint_drive_min_pos", "joint_drive_max_pos",
    "arm_max_line_speed", "arm_max_line_acc", "arm_max_angular_speed", "arm_max_angular_acc",
    "arm_power_state", "collision_stage", "arm_run_mode", "DH_data", "current_tool_frame",
    "current_work_frame", "total_tool_frame", "total_work_frame", "install_pose", "init_pose",
    "joint_software_version", "tool_software_version", "arm_current_trajectory", "system_runtime",
    "joint_odom", "self_collision_enable", "force_data", "realtime_push",
)  # fmt: skip
WRITE = (
    ("set_joint_max_speed", 1, 90.0), ("set_joint_max_acc", 1, 300.0), ("set_joint_min_pos", 1, -170.0),
    ("set_joint_max_pos", 1, 170.0), ("set_joint_max_speed", 1, 180.0), ("set_joint_max_acc", 1, 600.0),
    ("set_arm_max_line_speed", 0.2), ("set_arm_max_line_acc", 1.5), ("set_arm_max_angular_speed", 0.5),
    ("set_arm_max_angular_acc", 3.0), ("set_arm_tcp_init",), ("set_collision_state", 4),
    ("set_collision_state", 0), ("clear_system_err",), ("set_joint_clear_err", 1), ("set_arm_run_mode", 1),
    ("set_install_pose", 0.0, 90.0, 0.0), ("set_install_pose", 0.0, 0.0, 0.0),
    ("set_init_pose", [0.0] * 6), ("set_self_collision_enable", True), ("set_joint_en_state", 1, 1),
)  # fmt: skip
READY = [0, 20, -100, 0, -60, 0]  # [deg]
FAST = 100


class Session:
    """Calls and what they return."""

    def __init__(self, port):
        self.arm = RoboticArm(rm_thread_mode_e.RM_TRIPLE_MODE_E)
        self.tell("create", 0 if self.arm.rm_create_robot_arm("127.0.0.1", port).id > 0 else -1)

    def tell(self, name, code):
        print(json.dumps({"call": name, "code": code}), flush=True)

    def call(self, name, *arguments):
        result = getattr(self.arm, f"rm_{name}")(*arguments)
        code = result[0] if isinstance(result, tuple) else result
        self.tell(name, code["return_code"] if isinstance(code, dict) else code)
        return result

    def pose(self, x=0.0, y=0.0, z=0.0):
        now = list(self.arm.rm_get_current_arm_state()[1]["pose"])
        return [now[0] + x, now[1] + y, now[2] + z, *now[3:]]

    def frames(self):
        tool = rm_frame_t("brush", (0.0, 0.0, 0.1, 0.0, 0.0, 0.0), 0.35, 0.0, 0.0, 0.05)
        for name, argument in (("set_manual_tool_frame", tool), ("change_tool_frame", "brush"),
                               ("get_given_tool_frame", "brush"), ("update_tool_frame", tool),
                               ("change_tool_frame", "Arm_Tip"), ("delete_tool_frame", "brush")):  # fmt: skip
            self.call(name, argument)
        place = [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
        for name, *arguments in (("set_manual_work_frame", "bath", place), ("change_work_frame", "bath"),
                                 ("get_given_work_frame", "bath"), ("update_work_frame", "bath", place),
                                 ("change_work_frame", "Base"), ("delete_work_frame", "bath")):  # fmt: skip
            self.call(name, *arguments)

    def push(self, port):
        """Receive the state push for a while; codes and states that came."""
        self.samples = []
        self.callback = rm_realtime_arm_state_callback_ptr(
            lambda state: self.samples.append((state.errCode, state.arm_current_status))
        )
        self.arm.rm_realtime_arm_state_call_back(self.callback)
        self.call("set_realtime_push", rm_realtime_push_config_t(1, True, port, 0, "127.0.0.1"))

    def moves(self):
        self.call("movej", READY, FAST, 0, 0, 1)
        self.call("movel", self.pose(y=0.03), FAST, 0, 0, 1)
        self.call("movej_p", self.pose(y=-0.03), FAST, 0, 0, 1)
        self.call("movec", self.pose(y=0.02, z=0.02), self.pose(y=0.04), FAST, 0, 0, 0, 1)
        self.call("movej", READY, FAST, 0, 1, 1)  # waits for the next
        self.call("movej", [0, 25, -100, 0, -60, 0], FAST, 0, 0, 1)
        self.call("moves", self.pose(y=0.02), FAST, 0, 1, 1)
        self.call("moves", self.pose(y=0.03, z=0.01), FAST, 0, 0, 1)
        self.call("set_joint_step", 1, 3.0, FAST, 1)
        self.call("set_pos_step", rm_pos_teach_type_e.RM_Z_DIR_E, 0.01, FAST, 1)
        self.call("set_ort_step", rm_ort_teach_type_e.RM_RZ_ROTATE_E, 0.05, FAST, 1)

    def streams(self):
        self.call("movej", READY, FAST, 0, 0, 1)
        joints, codes = list(READY), set()
        for _ in range(30):
            joints[5] += 0.2
            codes.add(self.arm.rm_movej_canfd(joints, True, 0, 0, 0))
            time.sleep(0.01)
        codes.add(self.arm.rm_movep_canfd(self.pose(), True, 0, 0))
        codes |= {self.arm.rm_movej_follow(joints), self.arm.rm_movep_follow(self.pose())}
        self.call("set_movev_canfd_init", 0, 0, 10)
        codes.add(self.arm.rm_movev_canfd([0.01, 0.0, 0.0, 0.0, 0.0, 0.0], True, 0, 0))
        self.tell("streams", 0 if codes == {0} else str(codes))
        time.sleep(0.3)

    def stops(self):
        def pause_and_go_on():
            time.sleep(0.3)
            self.call("set_arm_pause")
            time.sleep(0.3)
            self.call("set_arm_continue")

        self.call("movej", READY, FAST, 0, 0, 1)
        aside = threading.Thread(target=pause_and_go_on)
        aside.start()
        self.call("movej", [40, 20, -100, 0, -60, 0], 30, 0, 0, 1)
        aside.join()
        for stop in ("set_arm_stop", "set_arm_slow_stop"):
            self.call("movej", READY, 10, 0, 0, 0)
            time.sleep(0.2)
            self.call(stop)
            time.sleep(0.5)
        self.call("movej", READY, FAST, 0, 0, 1)

    def forces(self):
        self.call("clear_force_data")
        self.call("set_force_position", 1, 1, 2, 0.0)
        self.call("stop_force_position")
        self.call("set_arm_power", 0)
        self.call("set_arm_power", 1)


def main(port, udp_port, generation):
    session = Session(port)
    for name in READ:
        session.call(f"get_{name}")
    session.push(udp_port)
    for name, *arguments in WRITE:
        session.call(name, *arguments)
    session.frames()
    session.moves()
    session.streams()
    session.stops()
    session.forces()
    if generation == 4:
        session.call("movel_offset", [0.0, 0.0, 0.01, 0.0, 0.0, 0.0], FAST, 0, 0, 0, 1)
        session.call("set_arm_emergency_stop", True)
        session.call("set_arm_emergency_stop", False)
    codes, states = (sorted(set(values)) for values in zip(*session.samples, strict=True))
    print(json.dumps({"call": "push", "code": codes, "states": states, "count": len(session.samples)}))
    session.tell("delete", session.arm.rm_delete_robot_arm())


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
