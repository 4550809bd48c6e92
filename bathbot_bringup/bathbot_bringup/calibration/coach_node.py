"""The calibration coach: hears the running camera, gathers views, says which poses are missing.

Pictures stay in the memory of this process; of each pose it keeps the corners and the mean depth.
"""

from bathbot_depthcorr.calibration.guards import BOARD_DEMANDS
from bathbot_depthcorr.views.bag_views import Recording
from bathbot_depthcorr.views.chessboard import Chessboard

from bathbot_bringup.calibration.camera_listener_node import CameraListener
from bathbot_bringup.calibration.coach import CoachLoop, CoachScreen
from bathbot_bringup.errors import InputError
from bathbot_bringup.graph.client_node import GraphClient

PATIENCE = 10.0  # [s] without a picture


def coach(board: Chessboard, camera: str = "camera/camera", patience: float = PATIENCE) -> Recording:
    """Gather views until all is covered, or until Enter or Ctrl-C with enough of them.

    Args:
        board: The chessboard on the wall.
        camera: Namespace of the camera's topics.
        patience: How long to wait for a picture [s].

    Raises:
        InputError: When the camera is silent, or falls silent before there are enough views.
        KeyboardInterrupt: On Ctrl-C with too few views.
    """
    with GraphClient("bathbot_coach") as client, CoachScreen() as screen:
        listener = CameraListener(client.node, camera, patience)
        if not client.spin_until(listener.knows_camera, patience):
            raise InputError(
                f"nothing on {', '.join(listener.silent())} within {patience:.0f} s; is the camera running, "
                "and is its namespace as --camera says?"
            )
        loop = CoachLoop(listener.begin(board), screen)

        def watch() -> None:
            listener.check()
            loop.work()

        client.watch = watch
        notes = []
        try:
            client.spin_until(loop.done, float("inf"))
        except (KeyboardInterrupt, InputError) as stop:
            if len(loop.views.poses) < BOARD_DEMANDS.views:
                raise
            notes = [str(stop)] if isinstance(stop, InputError) else []
        return loop.views.recording(listener.health)._replace(notes=notes)
