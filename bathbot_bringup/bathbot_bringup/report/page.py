"""The report as one HTML file that needs nothing beside it."""

import base64
import html
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from bathbot_scrub.arm.force_limits import shipped_force_limits

from bathbot_bringup.files import write_file
from bathbot_bringup.report import figures
from bathbot_bringup.report.coverage import patch_frame
from bathbot_bringup.report.measures import RunMeasures
from bathbot_bringup.report.run_data import Run
from bathbot_bringup.report.summary_table import table_rows
from bathbot_bringup.sim.brush import Brush

_BRUSH = Brush()
_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 60em; padding: 0 1em; color: #222; }
table { border-collapse: collapse; } td { padding: .2em 1.2em .2em 0; border-bottom: 1px solid #ddd; }
td + td { text-align: right; font-variant-numeric: tabular-nums; } img { max-width: 100%; }
.simulated { background: #fff3cd; border: 1px solid #e0c66a; padding: .5em 1em; }
.done { color: #0a7d4f; } .failed { color: #b3261e; }
"""
_NOTICE = (
    "SIMULATED. Person, camera, arm and forces come from models: bristles of "
    f"{_BRUSH.stiffness / 1e3:g} N/mm that give {_BRUSH.give * 1e3:g} mm, then stiff skin. "
    "Nothing here says that a real arm would be safe or pleasant for a real person."
)


def _image(figure: object, about: str) -> str:
    data = base64.b64encode(figures.png(figure)).decode("ascii")
    return f'<p><img alt="{html.escape(about)}" src="data:image/png;base64,{data}"></p>'


def _table(rows: Iterable[tuple[str, str]]) -> str:
    cells = (f"<tr><td>{html.escape(about)}</td><td>{html.escape(value)}</td></tr>" for about, value in rows)
    return f"<table>{''.join(cells)}</table>"


def _figures(run: Run, measures: RunMeasures, summary: Mapping[str, Any], epoch: float) -> list[str]:
    used, limits = summary.get("target_time_s"), shipped_force_limits().region(summary["region"])
    pictures = [
        _image(
            figures.draw_targets(measures.target_times - epoch, measures.target_errors, used),
            "localisation error",
        ),
        _image(figures.draw_force(run, epoch, limits, measures.force_threshold), "force over time"),
    ]
    if measures.path is not None and len(measures.path.T_base_head):
        poses = measures.path.T_base_head
        flat = patch_frame(poses).flatten(poses[:, :3, 3])[:, :2]
        pictures.insert(1, _image(figures.draw_path_error(measures.error), "path error"))
        pictures.append(_image(figures.draw_coverage(measures.coverage, flat), "coverage of the skin"))
    return pictures


def write_page(path: Path, summary: Mapping[str, Any], run: Run, measures: RunMeasures, epoch: float) -> None:
    """Write the report.

    Args:
        path: HTML file to write, in one step.
        summary: As in summary.json.
        run: Read from the bag.
        measures: Of the run.
        epoch: Beginning of the run [s].
    """
    done = summary["done"]
    state = '<span class="done">done</span>' if done else '<span class="failed">not done</span>'
    title = f"Bathing report: {summary['region']}, person {summary['seed']}"
    stages = [(name, f"{seconds:.1f} s") for name, seconds in summary["stages_s"].items()]
    failure = f'<p class="failed">{html.escape(summary["failure"])}</p>' if summary["failure"] else ""
    parts = [
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{html.escape(title)}</title>",
        f"<style>{_STYLE}</style>",
        f"<h1>{html.escape(title)}: {state}</h1><p class=simulated>{_NOTICE}</p>{failure}",
        f"<p>Scenario {html.escape(str(summary['scenario']))}, camera errors {summary['preset']}, "
        f"bathbot {html.escape(summary['version'])}.</p>",
        f"<h2>Numbers</h2>{_table(table_rows(summary))}<h2>Pictures</h2>",
        *_figures(run, measures, summary, epoch),
        f"<h2>Stages</h2>{_table(stages)}</html>\n",
    ]
    write_file(path, "\n".join(parts))
