"""`bathbot evaluate safety --sweep`: many trials in virtual time, on all cores."""

import multiprocessing
import os
import signal
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from bathbot_bringup.bench.machine import machine
from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.safety.sweep.sweep_case import Outcome, SweepCase
from bathbot_bringup.evaluation.safety.sweep.sweep_list import choose_cases
from bathbot_bringup.evaluation.safety.sweep.sweep_table import (
    markdown,
    out_of_bounds,
    print_sweep,
    summarise,
)
from bathbot_bringup.files import write_file, write_json


@dataclass(frozen=True, slots=True)
class SafetySweep:
    """What to sweep, and where the results go."""

    name: str
    seeds: Sequence[int]
    cases: Sequence[str] = ()  # names, where * stands for anything; none: all
    jobs: int | None = None  # trials at a time; None: one a core
    json_file: Path | None = None
    markdown_file: Path | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be swept."""
        choose_cases(self.name, self.cases)
        if self.jobs is not None and not 1 <= self.jobs <= 256:
            raise InputError(f"jobs must lie between 1 and 256, got {self.jobs}")


def sweep_safety(settings: SafetySweep, console: Console | None = None) -> int:
    """Run all trials, print the table, write numbers and table.

    Returns:
        0 if nothing was out of its bounds, else 1.
    """
    console = console or Console(highlight=False)
    for file in (settings.json_file, settings.markdown_file):
        if file is not None:
            file.parent.mkdir(parents=True, exist_ok=True)
    begun, here = time.monotonic(), machine()
    outcomes = run_all(settings, console)
    summary = summarise(settings.name, outcomes) | {
        "seeds": list(settings.seeds), "seconds": time.monotonic() - begun, "machine": here,
    }  # fmt: skip
    print_sweep(summary, console)
    if settings.json_file:
        write_json(settings.json_file, summary | {"results": [outcome._asdict() for outcome in outcomes]})
    if settings.markdown_file:
        write_file(settings.markdown_file, markdown(summary))
    return 1 if out_of_bounds(summary) else 0


def run_all(settings: SafetySweep, console: Console) -> list[Outcome]:
    """Run every case with every seed, in the order of the cases."""
    trials = [(case, seed) for case in choose_cases(settings.name, settings.cases) for seed in settings.seeds]
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    outcomes: dict[int, Outcome] = {}
    # a program that has threads must not be copied as it is
    context = multiprocessing.get_context("spawn")
    jobs = min(settings.jobs or len(os.sched_getaffinity(0)), len(trials))
    with (
        ProcessPoolExecutor(jobs, context, leave_interrupts) as pool,
        Progress(*columns, console=console, transient=True) as bar,
    ):
        task, hard = bar.add_task("trials", total=len(trials)), 0
        waiting = {pool.submit(run_trial, case, seed): place for place, (case, seed) in enumerate(trials)}
        try:
            for done in as_completed(waiting):
                outcome = outcomes[waiting[done]] = done.result()
                hard += outcome.peak_n > outcome.bound_n
                bar.update(task, advance=1, description=f"trials, {hard} too hard" if hard else "trials")
        except BaseException:  # Ctrl-C, too: only those end that run, in seconds
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [outcomes[place] for place in sorted(outcomes)]


def leave_interrupts() -> None:
    """Leave Ctrl-C to the program that began the pool."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def run_trial(case: SweepCase, seed: int) -> Outcome:
    """One trial, in a program of the pool."""
    return case.run(seed)
