"""The program that runs the trials of one seed and writes one line of JSON per trial."""

import json
import signal
import sys
from pathlib import Path
from typing import Any

from bathbot_bringup.errors import BringupError
from bathbot_bringup.evaluation.safety.fault_table import choose_faults
from bathbot_bringup.evaluation.safety.trial.seed_run import SeedRun
from bathbot_bringup.evaluation.safety.trial_result import TrialResult
from bathbot_bringup.graph.interruption import interrupt


def work(seed: int, names: list[str], folder: Path) -> None:
    """Run the trials of a seed.

    Args:
        seed: Which.
        names: Of the faults.
        folder: For traces, logs and `results.jsonl`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    cases = choose_faults(names)
    with (folder / "results.jsonl").open("w", encoding="utf-8") as file:

        def tell(result: TrialResult | dict[str, Any]) -> None:
            entry = result._asdict() if isinstance(result, TrialResult) else result
            file.write(json.dumps(entry) + "\n")  # Infinity and NaN are read back by our own json
            file.flush()

        try:
            SeedRun(seed, folder).run(cases, tell)
        except BringupError as error:
            print(error, file=sys.stderr)
            raise SystemExit(1) from error


def main() -> None:
    """Run with: seed, names of faults with commas between, folder."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    try:
        work(int(sys.argv[1]), sys.argv[2].split(","), Path(sys.argv[3]))
    except KeyboardInterrupt:
        raise SystemExit(130) from None


if __name__ == "__main__":
    main()
