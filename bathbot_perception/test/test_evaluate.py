import json

import cv2
import numpy as np
import pytest
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import AnnotationError, SettingsError
from bathbot_perception.evaluation.evaluate import evaluate
from bathbot_perception.pictures.voc import Annotation, read_annotation, write_annotation
from bathbot_perception.regions import Region
from tiny_model import row

HAND = row("Hand_skin", 0.9, (32.0, 24.0), (16.0, 8.0))
WRONG = row("Foot_skin", 0.6, (10.0, 10.0), (8.0, 8.0))


@pytest.fixture
def data_set(tmp_path):
    folder = tmp_path / "set"
    (folder / "images").mkdir(parents=True)
    (folder / "annotations").mkdir()
    for index in range(12):
        cv2.imwrite(str(folder / f"images/{index}.png"), np.zeros((64, 128, 3), np.uint8))
        regions = (
            Region("Hand_skin", 1.0, (48.0, 40.0, 80.0, 56.0)),
            Region("Foot_skin", 1.0, (90.0, 0.0, 120.0, 20.0)),
        )
        write_annotation(folder / f"annotations/{index}.xml", Annotation(f"{index}.png", 128, 64, regions))
    return folder


def test_a_report_has_the_agreed_keys_and_the_right_numbers(write_model, data_set, tmp_path):
    report = evaluate(data_set, write_model([HAND, WRONG]), curves=tmp_path / "curves/pr.png")
    assert set(report["ap50"]) == set(SKIN_CLASSES)
    assert report["ap50"]["Hand_skin"] == 1.0
    assert report["ap50"]["Foot_skin"] == 0.0
    assert report["ap50"]["Face_skin"] is None
    assert report["map50"] == report["map50_95"] == 0.5
    assert report["images"] == 12
    assert report["boxes"]["Hand_skin"] == 12
    assert report["ms_per_image_p50"] > 0
    assert cv2.imread(str(tmp_path / "curves/pr.png")) is not None
    json.dumps(report)


def test_low_scores_count_in_the_curve(write_model, data_set):
    faint = row("Hand_skin", 0.05, (32.0, 24.0), (16.0, 8.0))
    assert evaluate(data_set, write_model([faint]))["ap50"]["Hand_skin"] == 1.0


def test_splits_are_evaluated_apart_and_progress_is_told(write_model, data_set):
    model, seen = write_model([HAND]), []
    parts = [evaluate(data_set, model, split=s)["images"] for s in ("train", "val", "test")]
    assert sum(parts) == 12
    conditions = ("steam", "blur")
    evaluate(data_set, model, conditions=conditions, progress=lambda done, count: seen.append((done, count)))
    assert seen[-1] == (12 * 7, 12 * 7)
    with pytest.raises(SettingsError, match="split must be one of"):
        evaluate(data_set, model, split="dev")


def test_boxes_of_another_copy_or_no_boxes_at_all_are_refused(write_model, data_set):
    model, first = write_model([HAND]), next((data_set / "images").iterdir())
    whole = cv2.imread(str(first))
    cv2.imwrite(str(first), whole[:-4])
    with pytest.raises(AnnotationError, match="drawn on another copy"):
        evaluate(data_set, model, conditions=())
    cv2.imwrite(str(first), whole)
    for file in (data_set / "annotations").iterdir():
        annotation = read_annotation(file)
        write_annotation(file, annotation._replace(regions=()))
    with pytest.raises(AnnotationError, match="has a box of a skin class"):
        evaluate(data_set, model, conditions=())


def test_missed_boxes_that_are_difficult_are_told_apart(write_model, data_set):
    """The model finds the hand and not the foot: half of it counts only while the foot does."""
    for file in (data_set / "annotations").iterdir():
        annotation = read_annotation(file)
        hand, foot = annotation.regions
        write_annotation(file, annotation._replace(regions=(hand,), difficult=(foot,)))
    report = evaluate(data_set, write_model([HAND]), conditions=("blur",))
    assert (report["map50"], report["map50_with_difficult"], report["difficult"]) == (1.0, 0.5, 12)
    assert report["conditions"]["blur"]["middle"] == 1.0
    assert report["ap50"]["Foot_skin"] is None
