"""`bathbot evaluate safety`: the fault matrix over many seeds, each in a program of its own."""

import json
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from bathbot_bringup.bench.machine import machine
from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.safety.fault_table import FaultCase, choose_faults
from bathbot_bringup.evaluation.safety.figure import save_figure
from bathbot_bringup.evaluation.safety.summary import out_of_bounds, summarise
from bathbot_bringup.evaluation.safety.table import markdown, print_matrix
from bathbot_bringup.evaluation.safety.trial_result import TrialResult
from bathbot_bringup.files import write_file, write_json
from bathbot_bringup.graph.processes import Child, Patience, ProcessGroup, node_environment

_PATIENCE: Patience = ((signal.SIGINT, 20.0), (signal.SIGKILL, 2.0))  # a worker ends its own processes first
_POLL = 0.2  # [s]
_LONGEST = 60.0  # [s] no trial takes longer on average, whatever goes wrong
_MODULE = "bathbot_bringup.evaluation.safety.seed_run"


@dataclass(frozen=True, slots=True)
class SafetyEvaluation:
    """What to evaluate, and where the results go."""

    seeds: Sequence[int]
    faults: Sequence[str] = ()  # names; none: all
    jobs: int = 1  # graphs at a time
    json_file: Path | None = None
    markdown_file: Path | None = None
    picture: Path | None = None
    out: Path | None = None  # keeps traces and logs

    def __post_init__(self) -> None:
        """Refuse what cannot be evaluated."""
        choose_faults(self.faults)
        if not 1 <= self.jobs <= 16:
            raise InputError(f"jobs must lie between 1 and 16, got {self.jobs}")


class _Worker:
    """The program of one seed, and how much of its results has been read."""

    def __init__(self, group: ProcessGroup, seed: int, cases: Sequence[FaultCase], folder: Path) -> None:
        self.seed, self._cases, self.results = seed, cases, folder / "results.jsonl"
        names = ",".join(case.name for case in cases)
        command = [sys.executable, "-m", _MODULE, str(seed), names, str(folder)]
        self.child: Child = group.start(f"seed-{seed}", command)
        self._until = time.monotonic() + _LONGEST * len(cases)
        self._read = 0
        self.over = False  # it has ended, and all it did was read

    def news(self) -> list[dict[str, Any]]:
        """Results since the last call; once it has ended, what it did not do as well."""
        self.over = self.child.process.poll() is not None
        if not self.over and time.monotonic() > self._until:
            self.child.process.send_signal(signal.SIGINT)
        lines = self.results.read_text(encoding="utf-8").split("\n")[:-1] if self.results.exists() else []
        new, self._read = [json.loads(line) for line in lines[self._read :]], len(lines)
        if self.over:
            done = {json.loads(line)["fault"] for line in lines}
            reason = self.child.last_line() or "its program ended early"
            new += [
                {"fault": case.name, "seed": self.seed, "reason": reason}
                for case in self._cases
                if case.name not in done
            ]
        return new


def evaluate_safety(settings: SafetyEvaluation, console: Console | None = None) -> int:
    """Run all trials, print the matrix, write numbers, table and picture.

    Returns:
        0 if nothing was out of its bounds, else 1.
    """
    console = console or Console(highlight=False)
    files = (settings.json_file, settings.markdown_file, settings.picture)
    for folder in {file.parent for file in files if file is not None}:
        folder.mkdir(parents=True, exist_ok=True)
    cases, here, begun = choose_faults(settings.faults), machine(), time.monotonic()
    entries = run_all(settings, cases, console)
    trials = [TrialResult(**entry) for entry in entries if "reason" not in entry]
    trials.sort(key=lambda trial: (trial.seed, trial.fault))
    summary = summarise(trials, [entry for entry in entries if "reason" in entry]) | {
        "seeds": list(settings.seeds), "jobs": settings.jobs, "seconds": time.monotonic() - begun,
        "machine": here,
    }  # fmt: skip
    print_matrix(summary, console)
    if settings.json_file:
        write_json(settings.json_file, summary | {"results": [trial._asdict() for trial in trials]})
    if settings.markdown_file:
        write_file(settings.markdown_file, markdown(summary))
    if settings.picture and trials:
        save_figure(settings.picture, trials)
    return 1 if out_of_bounds(summary) else 0


def run_all(settings: SafetyEvaluation, cases: Sequence[FaultCase], console: Console) -> list[dict[str, Any]]:
    """Run one program per seed, some at a time; give one entry per trial."""
    waiting, working = list(settings.seeds), []
    entries: list[dict[str, Any]] = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with tempfile.TemporaryDirectory() as temporary:
        logs = settings.out.absolute() if settings.out else Path(temporary)
        with (
            ProcessGroup(logs, node_environment(logs), _PATIENCE) as group,
            Progress(*columns, console=console, transient=True) as bar,
        ):
            task = bar.add_task("trials", total=len(waiting) * len(cases))
            while waiting or working:
                while waiting and len(working) < settings.jobs:
                    seed = waiting.pop(0)
                    working.append(_Worker(group, seed, cases, logs / f"run-{seed}"))
                time.sleep(_POLL)
                for worker in list(working):
                    news = worker.news()
                    entries += news
                    if worker.over:
                        working.remove(worker)
                    bar.update(task, advance=len(news), description=_description(entries))
    return entries


def _description(entries: Sequence[dict[str, Any]]) -> str:
    missed = sum("reason" in entry or entry["missed"] for entry in entries)
    return f"trials, {missed} missed" if missed else "trials"
