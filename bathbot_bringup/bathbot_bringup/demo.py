"""The demo: the graph as processes, the job step by step, the report."""

import time

from bathbot_bringup.bathing.client_node import Bather
from bathbot_bringup.bathing.job import BathingJob
from bathbot_bringup.bathing.nodes import demo_nodes
from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.bathing.steps import Sighting
from bathbot_bringup.errors import ProcessError, StepError
from bathbot_bringup.graph.isolation import free_ports
from bathbot_bringup.graph.running import RunningGraph, started
from bathbot_bringup.graph.stages import StageLog
from bathbot_bringup.report.report import BAG, Outcome, report_run
from bathbot_bringup.report.summary_table import print_summary

START_TIMEOUT = 100.0  # [s] for all nodes to be active; a quiet machine takes about 10
RECORDED = ("/arm_state", "/contact_targets", "/planned_path", "/scrub_segments", "/sim_contact", "/tf")
RECORDER_TIMEOUT = 10.0  # [s] for the recorder to hear these


def run_demo(settings: DemoSettings, log: StageLog | None = None) -> int:
    """Do the whole job and report on it.

    Returns:
        Exit code: 0 if the job was done, else 1.

    Raises:
        ProcessError: When a node refuses to start for bad input.
        KeyboardInterrupt: On Ctrl-C, after all processes have ended and the report is written.
    """
    log = log or StageLog()
    settings.out.mkdir(parents=True, exist_ok=True)
    log.say(f"bathing {settings.region} of simulated person {settings.seed}, scenario {settings.scenario}")
    job = DemoJob(settings, log)
    interruption: KeyboardInterrupt | None = None
    try:
        job.run()
    except KeyboardInterrupt as stop:
        job.failure, interruption = str(stop) or "interrupted by Ctrl-C", stop
    except (StepError, ProcessError) as error:
        if job.starting and isinstance(error, ProcessError) and error.exit_code == 2:
            raise
        job.failure = str(error)
    if job.failure:
        log.say(f"NOT DONE: {job.failure}")
    outcome = Outcome(job.failure, job.epoch, job.sighting, log.times, log.elapsed)
    with log.stage("report", "compare with the simulated truth"):
        summary = report_run(settings, outcome)
    print_summary(log.console, summary)
    files = sorted(file.name for file in settings.out.iterdir() if file.is_file())
    log.say(f"results are in {settings.out}: {', '.join(files)}")
    if interruption:
        raise interruption
    return 0 if summary["done"] else 1


def _wait_until_recorded(graph: RunningGraph) -> None:
    """Wait until the recorder hears what the report is made of.

    Raises:
        ProcessError: When it does not within a few seconds.
    """
    node = graph.client.node

    def unheard() -> list[str]:
        listeners = {topic: node.get_subscriptions_info_by_topic(topic) for topic in RECORDED}
        names = {topic: {one.node_name for one in found} for topic, found in listeners.items()}
        return [topic for topic, found in names.items() if "recorder" not in found]

    if not graph.client.spin_until(lambda: not unheard(), RECORDER_TIMEOUT):
        raise ProcessError("recorder", f"does not listen to {', '.join(unheard())}", "", "its log")


class DemoJob:
    """One run of the graph; remembers how far it came.

    Attributes:
        epoch: ROS time at which the body's motion began [s].
        starting: True until every node was active.
        failure: Why the job was not done; empty when it was.
    """

    def __init__(self, settings: DemoSettings, log: StageLog) -> None:
        """Begin the time of the body."""
        self._settings, self._log = settings, log
        self._job: BathingJob | None = None
        self.epoch = time.time()
        self.starting = True
        self.failure = ""

    @property
    def sighting(self) -> Sighting | None:
        """The contact target that was approached, once there is one."""
        return self._job.sighting if self._job is not None else None

    def run(self) -> None:
        """Start the graph, bathe, and end every process, whatever happens."""
        settings, out = self._settings, self._settings.out.absolute()
        nodes = demo_nodes(settings, self.epoch, free_ports(), out / BAG)
        with started(nodes, out / "logs", "bathbot_demo") as graph:
            with self._log.stage("start", f"start {len(nodes)} nodes on DDS domain {graph.domain}"):
                graph.wait_until_active(START_TIMEOUT)
                _wait_until_recorded(graph)
            self.starting = False
            self._job = BathingJob(Bather(graph.client, settings.region), self._log, settings.duration)
            self._job.run()
