"""The `bathbot` command: one word per job, one line per mistake.

A mistake of the user (a `BathbotError`, a bad option, a file that cannot be opened) ends in one
line on stderr and exit code 2; Ctrl-C ends in 130, SIGTERM in 143, a closed terminal in 129, after
whatever runs has been stopped.
"""

import sys
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import typer
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.files import keep_private

from bathbot_bringup.command import (
    bags,
    bathing,
    bench,
    calibrate,
    detect,
    evaluate,
    keys,
    models,
    node,
    simulate,
)
from bathbot_bringup.graph.interruption import heed_signals, interrupted_code

BAD_INPUT, INTERRUPTED = 2, 130

app = typer.Typer(
    name="bathbot",
    help="A robot arm that washes a seated person: simulation, tools for cameras and bags, evaluation.\n\n"
    "Start with `bathbot demo`; every command explains itself with --help.",
    no_args_is_help=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
app.command("demo")(bathing.demo)
app.command("bathe")(bathing.bathe)
for verb in ("stop", "pause", "resume", "retract", "home", "status", "regions"):
    app.command(verb)(getattr(bathing, verb))
app.command("detect")(detect.detect)
app.command("replay")(bags.replay)
app.command("record")(bags.record)
app.command("repair")(bags.repair)
app.add_typer(calibrate.app, name="calibrate")
app.add_typer(evaluate.app, name="evaluate")
app.add_typer(bench.app, name="bench")
app.add_typer(models.train, name="train")
app.add_typer(models.export, name="export")
app.add_typer(simulate.app, name="simulate")
app.command(  # its help is also that of each node, which it writes itself
    "node",
    context_settings={"ignore_unknown_options": True, "allow_extra_args": True, "help_option_names": []},
)(node.node)
app.command("clean")(node.clean)
app.command("keys")(keys.keys)
app.command("sim-arm", cls=node.FaultHelp)(node.sim_arm)


def _show_version(wanted: bool) -> None:
    if wanted:
        from bathbot_bringup.graph.installation import version

        typer.echo(f"bathbot {version()}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(
        False, "--version", callback=_show_version, is_eager=True, help="Show the version."
    ),
) -> None:
    """Take the options that stand before the command."""


def _complain(message: str) -> int:
    print(f"bathbot: {' '.join(message.split())}", file=sys.stderr)
    return BAD_INPUT


def _about_option(error: Any, arguments: Sequence[str]) -> str:
    """Say what typer found wrong, the value it saw, and where help is."""
    names = getattr(getattr(error, "param", None), "opts", ())
    given = [value for name, value in pairwise(arguments) if name in names]
    seen = f", got {given[-1]!r}" if given else ""
    command = getattr(getattr(error, "ctx", None), "command_path", "bathbot")
    said = error.format_message().rstrip(".") or "no command was given"
    return f"{said}{seen}; see {command} --help"


def run(arguments: Sequence[str]) -> int:
    """Run one command line and give its exit code."""
    try:
        result = app(args=list(arguments) or ["--help"], prog_name="bathbot", standalone_mode=False)
    except BathbotError as error:
        return _complain(str(error))
    except OSError as error:
        if error.filename is None:
            raise
        return _complain(f"{error.strerror}: {error.filename}; check the path and its permissions")
    except (KeyboardInterrupt, typer.Abort):
        return interrupted_code()
    except Exception as error:
        if not hasattr(error, "format_message"):  # typer's complaints have it, real faults do not
            raise
        return _complain(_about_option(error, list(arguments)))
    if result == INTERRUPTED:  # typer makes that of every interruption
        return interrupted_code()
    return result if isinstance(result, int) else 0


def main() -> None:
    """Run the command line of this process."""
    heed_signals()
    keep_private()
    sys.exit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
