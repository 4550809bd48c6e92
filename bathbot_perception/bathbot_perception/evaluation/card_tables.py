"""Reports of `evaluate` as Markdown tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.evaluation.conditions import CONDITIONS, STRENGTHS
from bathbot_perception.evaluation.skin_tone import THIRDS

Report = Mapping[str, Any]
_SHORT = [name.removesuffix("_skin") for name in SKIN_CLASSES]


def markdown(head: list[str], rows: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def accuracy_table(reports: Mapping[str, Report]) -> str:
    """MAP and AP50 per class of each report, by its title; mAP50 also with the boxes marked difficult."""
    rows = [
        [
            title,
            str(report["images"]),
            shown(report["map50"]),
            shown(report["map50_with_difficult"]),
            shown(report["map50_95"]),
            *(shown(report["ap50"][name]) for name in SKIN_CLASSES),
        ]
        for title, report in reports.items()
    ]
    return markdown(["data", "pictures", "mAP50", "with difficult boxes", "mAP50-95", *_SHORT], rows)


def condition_table(reports: Mapping[str, Report]) -> str:
    """MAP50 under each condition, at the three strengths, and how far that is from the clean pictures.

    Reports without conditions are left out.
    """
    tried = {title: report for title, report in reports.items() if report["conditions"]}
    head = ["condition", "what the strengths are", *(f"{title}: {s}" for title in tried for s in STRENGTHS)]
    clean = ["none", "", *(shown(report["map50"]) for report in tried.values() for _ in STRENGTHS)]
    rows = [
        [
            name,
            f"{condition.meaning}: {', '.join(f'{value:g}' for value in condition.values)}",
            *(
                _beside(report["conditions"][name][strength], report["map50"])
                for report in tried.values()
                for strength in STRENGTHS
            ),
        ]
        for name, condition in CONDITIONS.items()
    ]
    return markdown(head, [clean, *rows])


def tone_table(reports: Mapping[str, Report]) -> str:
    """MAP50 of each third of the pictures by skin tone, and the angles between the thirds."""
    rows = [
        [
            title,
            *(shown(report["conditions"]["skin_tone"][third]) for third in THIRDS),
            " and ".join(f"{angle:.0f}" for angle in reversed(report["ita_deg"])),
        ]
        for title, report in reports.items()
        if report["conditions"]
    ]
    return markdown(["data", *THIRDS, "ITA between the thirds [deg]"], rows)


def confusion_table(report: Report) -> str:
    """Numbers of regions: true class down, found class across."""
    names = [*_SHORT, "background"]
    rows = [
        [name, *(str(count) for count in counts)]
        for name, counts in zip(names, report["confusion"], strict=True)
    ]
    return markdown(["true \\ found", *names], rows)


def time_table(benches: Sequence[Report]) -> str:
    """Times of each model in each result of `bathbot bench detector`, medians."""
    rows = [
        [
            name,
            str(bench["threads"]),
            bench["input"],
            f"{taken['runtime']:.1f}",
            f"{taken['node']:.1f}",
            f"{taken['node'] / taken['runtime']:.2f}",
            f"{1e3 / taken['node']:.0f}",
        ]
        for bench in benches
        for name, taken in bench["models"].items()
    ]
    return markdown(
        ["model", "threads", "input", "runtime [ms]", "node [ms]", "node / runtime", "pictures/s"], rows
    )


def shown(value: float | None) -> str:
    """Three digits, or a dash."""
    return "-" if value is None else f"{value:.3f}"


def _beside(value: float | None, clean: float | None) -> str:
    return "-" if value is None or clean is None else f"{value:.3f} ({value - clean:+.3f})"
