"""`bathbot evaluate`: numbers over many pictures or many seeds."""

from pathlib import Path

import typer

from bathbot_bringup.command.arguments import (
    CALIBRATION,
    PRESET,
    RATE,
    name_list,
    refuse_with,
    seed_list,
    unused_folder,
    writable,
)

app = typer.Typer(
    help="Measure, over many pictures or many seeds.", no_args_is_help=False, rich_markup_mode=None
)


@app.callback()
def _group() -> None:
    """Measure, over many pictures or many seeds."""


@app.command("detector")
def detector(
    dataset: Path = typer.Argument(..., help="PASCAL VOC folder: images/ and annotations/."),
    json_file: Path = typer.Option(
        None, "--json", callback=writable, help="Write the numbers to this file too."
    ),
    model: str = typer.Option("", help="ONNX file; leave it out for the model that comes with bathbot."),
    split: str = typer.Option("all", help="Which pictures: all, checked, train, val or test."),
    curves: Path = typer.Option(None, help="Draw precision over recall to this PNG file."),
    conditions: str = typer.Option(
        "all", help="Steam, dark, bright, occlusion ...: all, none, or names with commas between."
    ),
) -> None:
    """Compare the detector with labelled pictures: average precision per class, and under bad conditions.

    Every condition - steam, dark, bright, occlusion, blur, motion_blur, wet_highlights, drops - at three
    strengths, and the pictures in thirds by skin tone. Boxes marked difficult count neither way.

    \b
      bathbot evaluate detector my_photos --json detector.json
      bathbot evaluate detector my_photos --split test --model skin.onnx --conditions none
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_perception.evaluation.conditions import CONDITIONS
    from bathbot_perception.evaluation.evaluate import evaluate

    from bathbot_bringup.evaluation.detector_table import counting, print_detector
    from bathbot_bringup.files import write_json

    wanted = {"all": tuple(CONDITIONS), "none": ()}.get(conditions, tuple(conditions.split(",")))
    with counting() as progress:
        result = evaluate(
            dataset, model or None, split=split, curves=curves, conditions=wanted, progress=progress
        )
    print_detector(result)
    if json_file:
        write_json(json_file, result)


@app.command("depth")
def depth(
    seeds: str = typer.Option("5", help="Number of simulated cameras, or their seeds such as 0-4 or 2-2."),
    preset: str = typer.Option(
        "paper", help="Error model of the cameras: paper, yaw, good, half, fixed or perfect."
    ),
    json_file: Path = typer.Option(None, "--json", callback=writable, help="Write all numbers to this file."),
    figures: Path = typer.Option(None, help="Folder for the pictures; none are drawn if left out."),
    size: str = typer.Option("1280x720", help="Of the depth pictures [px]: 1280x720, 848x480 or 640x360."),
    poses: int = typer.Option(24, min=10, max=200, help="Views of each calibration."),
    frames: int = typer.Option(4, min=1, max=30, help="Depth frames averaged in each view."),
    sweeps: bool = typer.Option(
        False, "--sweeps", help="Also vary poses, tilts, wrong squares and the like; takes minutes."
    ),
) -> None:
    """Calibrate simulated cameras by every method and compare each with the truth.

    Systematic error (noise off) by distance with 95 % intervals, single frames with noise, curved
    surfaces, and the paper's Table 2 replayed beside its published figures. The same views, the same
    colour reference and the same priors for all methods. About 40 s a camera.

    \b
      bathbot evaluate depth --json depth.json
      bathbot evaluate depth --preset yaw --seeds 0-9 --figures pictures
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.command.arguments import count_or_seeds, picture_size
    from bathbot_bringup.evaluation.depth.run import DepthEvaluation, evaluate_depth

    evaluate_depth(
        DepthEvaluation(
            count_or_seeds(seeds), preset, picture_size(size), poses, frames, sweeps, figures, json_file
        )
    )


@app.command("demo")
def demo(
    seeds: str = typer.Option("0-19", help="Seeds such as 3, 0-19 or 0-4,7."),
    json_file: Path = typer.Option(
        None, "--json", callback=writable, help="Write all summaries and their spread to this file."
    ),
    out: Path = typer.Option(
        None,
        callback=unused_folder,
        help="Folder to make for the results of each seed.",
    ),
    region: str = typer.Option("Trunk_skin", help="Region to bathe."),
    scenario: str = typer.Option("calm", help="How the person moves."),
    duration: float = typer.Option(60.0, help="Longest time of scrubbing [s]."),
    rate: float = RATE,
    preset: str = PRESET,
    calibration: Path = CALIBRATION,
) -> None:
    """Run the demo once per seed and print mean, spread and extremes of its numbers.

    The exit code is 0 only if every job was done.

    \b
      bathbot evaluate demo --seeds 0-19 --json demo.json
      bathbot evaluate demo --seeds 0-4 --region upperlimb --scenario restless
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bathing.settings import DemoSettings
    from bathbot_bringup.bathing.steps import full_region_name
    from bathbot_bringup.evaluation.demo import evaluate_demo
    from bathbot_bringup.graph.installation import SIM_CALIBRATION

    name, calibration = full_region_name(region), calibration or SIM_CALIBRATION

    def settings(seed: int, folder: Path) -> DemoSettings:
        return DemoSettings(name, seed, scenario, folder, duration, rate, preset, calibration)

    raise typer.Exit(evaluate_demo(settings, seed_list(seeds), json_file, out))


@app.command("localization")
def localization(
    seeds: str = typer.Option("0-9", help="Seeds such as 3, 0-19 or 0-4,7."),
    json_file: Path = typer.Option(None, "--json", callback=writable, help="Write all numbers to this file."),
    region: str = typer.Option("Trunk_skin", help="Region to locate."),
    scenario: str = typer.Option("calm", help="How the person moves."),
    targets: int = typer.Option(20, min=1, help="Contact targets per seed."),
    rate: float = RATE,
    preset: str = PRESET,
    calibration: Path = CALIBRATION,
) -> None:
    """Compare contact targets with the simulated truth, seed by seed, without moving the arm.

    \b
      bathbot evaluate localization --seeds 0-9 --json localization.json
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bathing.settings import DemoSettings
    from bathbot_bringup.bathing.steps import full_region_name
    from bathbot_bringup.evaluation.localization import evaluate_localization
    from bathbot_bringup.graph.installation import SIM_CALIBRATION

    name, calibration = full_region_name(region), calibration or SIM_CALIBRATION

    def settings(seed: int, folder: Path) -> DemoSettings:
        return DemoSettings(name, seed, scenario, folder, 60.0, rate, preset, calibration)

    raise typer.Exit(evaluate_localization(settings, seed_list(seeds), targets, json_file))


@app.command("regions")
def regions(
    seeds: str = typer.Option("0-99", help="Seeds such as 3, 0-19 or 0-4,7."),
    json_file: Path = typer.Option(None, "--json", callback=writable, help="Write all numbers to this file."),
    region: str = typer.Option("Trunk_skin", help="Region to find."),
    scenario: str = typer.Option("calm", help="The air, and how the person moves."),
    model: str = typer.Option("", help="ONNX file; leave it out for the model that comes with bathbot."),
) -> None:
    """Find a region in the first picture of the simulated bathroom, seed by seed, as the demo does.

    A region counts as found when a box of its class overlaps the true one by half (IoU). The exit code is 0
    only if it was found for every seed. About 2 s a seed.

    \b
      bathbot evaluate regions --seeds 0-99 --json regions.json
      bathbot evaluate regions --region face --model skin_int8.onnx
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bathing.steps import full_region_name
    from bathbot_bringup.evaluation.regions import evaluate_regions

    raise typer.Exit(evaluate_regions(seed_list(seeds), full_region_name(region), scenario, model, json_file))


@app.command("safety")
def safety(
    json_file: Path = typer.Option(None, "--json", callback=writable, help="Write all numbers to this file."),
    seeds: str = typer.Option(
        "0-19", help="Seeds such as 3, 0-19 or 0-4,7: another person, place and moment."
    ),
    faults: str = typer.Option("", help="Names of faults with commas between; all if left out."),
    jobs: int = typer.Option(
        None,
        help="Graphs at a time, one if left out: each takes about one core; trials of a sweep: all cores.",
    ),
    markdown_file: Path = typer.Option(
        None, "--markdown", callback=writable, help="Write the table to this Markdown file."
    ),
    picture: Path = typer.Option(
        None, callback=writable, help="Draw every trial's stop time to this PNG file."
    ),
    out: Path = typer.Option(
        None, callback=unused_folder, help="Folder to make for traces and logs; left out: none is kept."
    ),
    sweep: str = typer.Option("", help="Instead: meet a body in virtual time: pushes, leans or paths."),
    cases: str = typer.Option(
        "", help="Cases of the sweep with commas between, * fits anything; all if left out."
    ),
) -> None:
    """Make everything fail that can, and measure how the arm stops.

    The real driver against the emulated controller beside a simulated person, over DDS and the vendor's
    protocol. The exit code is 0 only if after every fault the arm stood or left within the deadline.

    With --sweep, the driver against the emulated arm in virtual time, where the body comes at many speeds;
    the exit code is 0 only if the body was never met harder than its region allows.

    \b
      bathbot evaluate safety --json safety.json --jobs 2
      bathbot evaluate safety --seeds 0-3 --faults body_push,lost_udp
      bathbot evaluate safety --sweep pushes --json pushes.json
      bathbot evaluate safety --sweep leans --seeds 7 --cases "blind-face-*"
    """  # noqa: D301 - \b keeps the lines of examples
    if sweep:
        from bathbot_bringup.evaluation.safety.sweep.sweep_run import SafetySweep, sweep_safety

        refuse_with("--sweep", {"--faults": faults, "--picture": picture, "--out": out})
        swept = SafetySweep(sweep, seed_list(seeds), name_list(cases), jobs, json_file, markdown_file)
        raise typer.Exit(sweep_safety(swept))

    from bathbot_bringup.evaluation.safety.run import SafetyEvaluation, evaluate_safety

    refuse_with("no --sweep", {"--cases": cases})
    names = name_list(faults)
    raise typer.Exit(
        evaluate_safety(
            SafetyEvaluation(
                seed_list(seeds), names, 1 if jobs is None else jobs, json_file, markdown_file, picture, out
            )
        )
    )
