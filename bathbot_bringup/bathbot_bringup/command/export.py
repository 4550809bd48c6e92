"""`bathbot export`: models in the form another machine wants."""

from pathlib import Path

import typer

from bathbot_bringup.command.arguments import writable

app = typer.Typer(help="Write models for other machines.", no_args_is_help=False, rich_markup_mode=None)


@app.callback()
def _group() -> None:
    """Write models for other machines."""


@app.command("detector")
def detector(
    out: Path = typer.Option(..., "--out", callback=writable, help="ONNX file to write."),
    model: str = typer.Option("", help="ONNX file; leave it out for the model that comes with bathbot."),
    precision: str = typer.Option(
        "fp16", help="fp32, fp16 (GPUs such as a Jetson TX2's) or int8 (CPUs; takes uint8)."
    ),
    shape: str = typer.Option("", help="Width and height of the input [px] for one shape only: 640x384."),
    dataset: Path = typer.Option(
        None, help="PASCAL VOC folder whose training pictures set the ranges of int8."
    ),
) -> None:
    """Write the skin detector in another precision or for one shape of input, as TensorRT wants it.

    The file is ONNX of opset 13, which TensorRT 8.2 reads; docs/jetson_tx2.md says how to go on there.

    \b
      bathbot export detector --precision fp16 --shape 640x384 --out skin_fp16.onnx
      bathbot export detector --precision int8 --dataset my_photos --out skin_int8.onnx
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_perception.detection.detector import model_file
    from bathbot_perception.export.convert import convert
    from bathbot_perception.export.quantise import PICTURES
    from bathbot_perception.pictures.splits import split_samples
    from rich.console import Console

    from bathbot_bringup.command.arguments import picture_size

    width, height = picture_size(shape) if shape else (0, 0)
    pictures = [sample.picture for sample in split_samples(dataset).train[:PICTURES]] if dataset else []
    console = Console(highlight=False, soft_wrap=True)
    with console.status(f"writing {out}"):
        made = convert(model_file(model), out, precision, (height, width) if shape else None, pictures)
    taken = f"{width}x{height} px only" if shape else "any multiples of 32 px"
    console.print(
        f"{out}: {precision}, {made.size_mb:.1f} MB, opset {made.opset}, input {taken}; "
        f"differs from the model it came from by {made.difference:.3g} px or score at most, on noise",
        markup=False,
    )
