"""`bathbot bathe`: the job on a graph that runs already, such as that of `robot.launch.py`."""

import typer


def bathe(
    region: str = typer.Option("Trunk_skin", help="Region to bathe; trunk, upperlimb, ... will do."),
    duration: float = typer.Option(60.0, min=1.0, max=600.0, help="Longest time of scrubbing [s]."),
    yes: bool = typer.Option(False, "--yes", help="Do not ask before the arm moves."),
) -> None:
    """Bathe a region with the nodes that run on this machine: look, approach, scrub, retract, go home.

    The arm MOVES. Keep the emergency stop in your hand; Ctrl-C stops the arm as well. Not a medical device.

    \b
      ros2 launch bathbot_bringup robot.launch.py arm_host:=192.168.1.18 ...   in another terminal
      bathbot bathe --region upperlimb
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bathing import full_region_name
    from bathbot_bringup.bathing_job import BathingJob
    from bathbot_bringup.bathing_node import Bather
    from bathbot_bringup.errors import StepError
    from bathbot_bringup.graph_client_node import GraphClient
    from bathbot_bringup.stages import StageLog

    name = full_region_name(region)
    if not yes:
        typer.confirm(f"The arm will move to {name}. Is the emergency stop at hand?", abort=True)
    log = StageLog()
    try:
        with GraphClient("bathbot_bathe") as client:
            BathingJob(Bather(client, name), log, duration).run()
    except StepError as error:
        log.say(f"NOT DONE: {error}")
        raise typer.Exit(1) from error
