"""The machine that something was timed on: without it a time says little."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def machine() -> dict[str, Any]:
    """Cores, processor and present load of this machine."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {"cores": os.cpu_count(), "cpu": models[0] if models else "unknown", "load": os.getloadavg()[0]}


def machine_words(here: Mapping[str, Any]) -> str:
    """The same for the caption of a table."""
    return f"{here['cores']} cores, {here['cpu']}, load {here['load']:.1f}"
