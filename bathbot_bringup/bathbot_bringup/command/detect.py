"""`bathbot detect`: skin regions in pictures, films, folders and bags."""

from pathlib import Path

import typer

from bathbot_bringup.command.arguments import unused_folder


def detect(
    paths: list[Path] = typer.Argument(
        ..., metavar="PATH...", help="Pictures, films, folders of them, or bags."
    ),
    out: Path = typer.Option(
        ..., "--out", callback=unused_folder, help="Folder to make for drawn copies and regions.csv."
    ),
    model: str = typer.Option("", help="ONNX file; leave it out for the model that comes with bathbot."),
    score: float = typer.Option(0.35, min=0.0, max=1.0, help="Regions below this score are dropped."),
    every: int = typer.Option(10, min=1, help="Of a bag, take every so many-th colour picture."),
) -> None:
    """Find regions of bare skin, draw them and list them.

    Writes a drawn copy of each picture and film, and one table `regions.csv`, to the folder --out.

    \b
      bathbot detect portrait.jpg --out found
      bathbot detect holiday/ clip.mp4 --out found
      bathbot detect board_run --every 30 --out found       a bag that holds pictures
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_perception.detection.detector import load
    from bathbot_perception.detection.settings import SkinDetectorSettings

    from bathbot_bringup.bag.detect import detect_paths

    detector = load(settings=SkinDetectorSettings(model=model, score_threshold=score))
    for found in detect_paths(paths, detector, out, every):
        where = found.source.name + (f" frame {found.frame}" if found.frame >= 0 else "")
        if found.note:
            typer.echo(f"{where}: {found.note}")
        for region in found.regions:
            left, top, right, bottom = region.box
            corners = f"{left:.0f},{top:.0f} - {right:.0f},{bottom:.0f}"
            typer.echo(f"{where}: {region.name} {region.score:.2f} at {corners}")
        if not found.regions:
            typer.echo(f"{where}: no bare skin found")
    typer.echo(f"drawn copies and regions.csv are in {out}")
