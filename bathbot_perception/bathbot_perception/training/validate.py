"""How good a network is on held-out pictures, with the same boxes and scores as at run time."""

import numpy as np
import torch
from torch import nn

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.letterbox import fit_input, letterbox
from bathbot_perception.detection.predictions import regions_from_predictions
from bathbot_perception.evaluation.average_precision import (
    PictureResult,
    average_precision,
    mean_average_precision,
    precision_recall,
)
from bathbot_perception.regions import Region
from bathbot_perception.training.data.augment_geometry import Example
from bathbot_perception.training.network.network import Yolov5s, predictions


@torch.no_grad()
def examine(model: Yolov5s, examples: list[Example], long_side: int) -> list[PictureResult]:
    """Truth and detections (score at least 0.01) of every example."""
    results = []
    model.eval()
    for example in examples:
        shape = example.picture.shape[:2]
        fit = fit_input(shape, long_side)
        tensor = torch.from_numpy(letterbox(example.picture, fit)).to(memory_format=torch.channels_last)
        with torch.autocast("cpu", torch.bfloat16):
            raw = predictions(model, tensor)[0].float().numpy()
        found = regions_from_predictions(raw, fit, shape, score_threshold=0.01, overlap_limit=0.5, most=100)
        truths = [
            Region(SKIN_CLASSES[index], 1.0, tuple(map(float, box)))
            for index, box in zip(example.classes, example.boxes, strict=True)
        ]
        results.append(PictureResult(truths, found))
    return results


def score_network(model: nn.Module, examples: list[Example], long_side: int) -> dict[str, float]:
    """mAP50 under "map50" and AP50 under each class name."""
    results = examine(model, examples, long_side)
    scores = {name: average_precision(precision_recall(results, name)) for name in SKIN_CLASSES}
    return {
        "map50": mean_average_precision(results, SKIN_CLASSES),
        **{k: float(np.round(v, 4)) for k, v in scores.items()},
    }
