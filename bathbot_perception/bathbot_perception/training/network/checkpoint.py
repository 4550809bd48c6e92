"""The state of a training run on disk, so that it can go on in a later sitting."""

import copy
import io
from dataclasses import dataclass
from pathlib import Path

import torch
from bathbot_depthcorr.files import write_atomically
from torch import Tensor

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import ModelError
from bathbot_perception.training.network.network import Yolov5s


class Average:
    """Exponential moving average of a network's weights, the ones that are kept in the end."""

    def __init__(self, model: Yolov5s, decay: float = 0.9995, ramp: float = 800.0) -> None:
        """Start from the network as it is; early on forget faster (`ramp` in steps)."""
        self.model = copy.deepcopy(model).eval().requires_grad_(False)
        self.decay, self.ramp, self.steps = decay, ramp, 0

    @torch.no_grad()
    def update(self, model: Yolov5s) -> None:
        """Move towards the network's present weights."""
        self.steps += 1
        decay = self.decay * (1.0 - 2.718281828 ** (-self.steps / self.ramp))
        for ours, theirs in zip(self.model.state_dict().values(), model.state_dict().values(), strict=True):
            if ours.dtype.is_floating_point:
                ours.lerp_(theirs, 1.0 - decay)
            else:
                ours.copy_(theirs)


@dataclass(slots=True)
class Run:
    """What changes while training."""

    model: Yolov5s
    average: Average
    optimiser: torch.optim.Optimizer
    size: int  # longer side of the pictures that the anchors are meant for [px]
    freeze_until: float = 0.0  # share of the budget with a frozen backbone
    step: int = 0
    seconds: float = 0.0
    best: float = -1.0
    lost: int = 0  # steps in a row whose gradient was no number


def save_run(path: Path, run: Run) -> None:
    """Write a checkpoint; the old one stays whole until the new one is."""
    state = {
        "model": run.model.state_dict(),
        "average": run.average.model.state_dict(),
        "average_steps": run.average.steps,
        "optimiser": run.optimiser.state_dict(),
        "size": run.size,
        "freeze_until": run.freeze_until,
        "step": run.step,
        "seconds": run.seconds,
        "best": run.best,
        "classes": list(SKIN_CLASSES),
    }
    content = io.BytesIO()
    torch.save(state, content)
    write_atomically(path, content.getvalue())


def read_state(path: Path) -> dict:
    """Read a checkpoint.

    Raises:
        ModelError: If it is none of ours or was trained for other classes.
    """
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
        classes, state["size"] = list(state["classes"]), int(state["size"])
        state.setdefault("freeze_until", 0.0)  # not in the oldest checkpoints
    except Exception as error:
        raise ModelError(
            f"cannot use {path} as a checkpoint: {error}; start a new run without --resume"
        ) from error
    if classes != list(SKIN_CLASSES):
        raise ModelError(f"the checkpoint {path} knows the classes {classes}, not {list(SKIN_CLASSES)}")
    return state


def restore_run(run: Run, state: dict) -> None:
    """Put a run where the checkpoint was."""
    run.model.load_state_dict(state["model"])
    run.average.model.load_state_dict(state["average"])
    run.average.steps = state["average_steps"]
    run.optimiser.load_state_dict(state["optimiser"])
    for group in run.optimiser.param_groups:
        group["fused"], group["foreach"] = isinstance(run.optimiser, torch.optim.AdamW), False
    run.size, run.step, run.seconds, run.best = (state[key] for key in ("size", "step", "seconds", "best"))


def optimiser_of(state: dict) -> str:
    """Which of `train_settings.OPTIMISERS` a checkpoint was trained with: only AdamW has betas."""
    return "adamw" if "betas" in state["optimiser"]["param_groups"][0] else "sgd"


def averaged_network(state: dict) -> Yolov5s:
    """The averaged network of a checkpoint, ready to use."""
    anchors: Tensor = state["average"]["anchors"]
    model = Yolov5s(len(SKIN_CLASSES), anchors)
    model.load_state_dict(state["average"])
    return model.eval()
