import json

import cv2
import numpy as np
import pytest
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.detector import load
from bathbot_perception.errors import SettingsError
from bathbot_perception.evaluation.average_precision import PictureResult
from bathbot_perception.evaluation.card_pictures import condition_sheet, failure_sheet, mistakes
from bathbot_perception.evaluation.card_tables import (
    accuracy_table,
    condition_table,
    confusion_table,
    time_table,
    tone_table,
)
from bathbot_perception.evaluation.conditions import CONDITIONS
from bathbot_perception.evaluation.model_card import fill_card, marks, read_benches, training_summary
from bathbot_perception.pictures.voc import Annotation, list_samples, write_annotation
from bathbot_perception.regions import Region
from tiny_model import row

BEGIN, END = marks("measured")


def test_only_the_marked_part_is_replaced(tmp_path):
    card = tmp_path / "card.md"
    card.write_text(f"# Title\n{BEGIN}\nold\n{END}\nrest\n")
    for text in ("first", "second"):
        fill_card(card, "measured", text)
    assert card.read_text() == f"# Title\n{BEGIN}\nsecond\n{END}\nrest\n"


def test_a_card_without_marks_is_left_alone(tmp_path):
    card = tmp_path / "card.md"
    card.write_text("# Title\n")
    with pytest.raises(SettingsError, match="must hold the lines"):
        fill_card(card, "measured", "text")
    assert card.read_text() == "# Title\n"


def report(**changes):
    """A report of `evaluate` as the card takes it."""
    ap50 = {name: 0.5 for name in SKIN_CLASSES} | {"Foot_skin": None}
    conditions = {name: {"mild": 0.5, "middle": 0.45, "strong": None} for name in CONDITIONS}
    conditions["skin_tone"] = {"lightest": 0.6, "middle": 0.5, "darkest": 0.4}
    whole = {
        "images": 3, "map50": 0.5, "map50_with_difficult": 0.4, "map50_95": 0.25, "ap50": ap50,
        "conditions": conditions, "ita_deg": [10.0, 41.4], "confusion": np.eye(7, dtype=int).tolist(),
    }  # fmt: skip
    return whole | changes


def test_the_accuracy_shows_every_class():
    table = accuracy_table({"photos": report()})
    assert (
        table.splitlines()[2]
        == "| photos | 3 | 0.500 | 0.400 | 0.250 | 0.500 | 0.500 | 0.500 | 0.500 | 0.500 | - |"
    )


def test_conditions_stand_beside_the_clean_pictures_and_only_where_tried():
    table = condition_table({"photos": report(), "photos, INT8": report(conditions={})})
    lines = table.splitlines()
    assert len(lines) == 3 + len(CONDITIONS)
    assert lines[0].count("photos: ") == 3
    assert lines[3].endswith("| 0.500 (+0.000) | 0.450 (-0.050) | - |")
    assert tone_table({"photos": report()}).endswith("| photos | 0.600 | 0.500 | 0.400 | 41 and 10 |")
    assert confusion_table(report()).splitlines()[-1] == "| background | 0 | 0 | 0 | 0 | 0 | 0 | 1 |"


def test_times_are_those_of_the_bench(tmp_path):
    bench = {"threads": 2, "input": "640x384", "models": {"int8": {"node": 12.5, "runtime": 10.0}}}
    (tmp_path / "bench.json").write_text(json.dumps(bench))
    lines = time_table(read_benches([tmp_path / "bench.json"] * 2)).splitlines()
    assert lines[2:] == ["| int8 | 2 | 640x384 | 10.0 | 12.5 | 1.25 | 80 |"] * 2


@pytest.mark.parametrize("text", [None, "", "[]", '{"models": {"int8": {}}, "threads": 2, "input": ""}'])
def test_a_file_of_something_else_is_no_bench(tmp_path, text):
    if text is not None:
        (tmp_path / "bench.json").write_text(text)
    with pytest.raises(SettingsError, match="is not from `bathbot bench detector --json`"):
        read_benches([tmp_path / "bench.json"])


def test_sheets_show_conditions_and_the_worst_pictures(write_model, tmp_path):
    detector = load(write_model([row("Hand_skin", 0.9, (32.0, 24.0), (16.0, 8.0))]))
    for name in ("images", "annotations"):
        (tmp_path / name).mkdir()
    for index in range(3):
        cv2.imwrite(str(tmp_path / f"images/{index}.png"), np.full((64, 128, 3), 90, np.uint8))
        regions = tuple(Region("Foot_skin", 1.0, (5.0, 5.0, 30.0 + i, 30.0)) for i in range(index))
        write_annotation(tmp_path / f"annotations/{index}.xml", Annotation(f"{index}.png", 128, 64, regions))
    samples = list_samples(tmp_path)
    condition_sheet(detector, samples[2], tmp_path / "new" / "conditions.png")
    failure_sheet(detector, samples, tmp_path / "failures.png", count=2)
    assert cv2.imread(str(tmp_path / "new" / "conditions.png")).shape == (258 * len(CONDITIONS), 960, 3)
    assert cv2.imread(str(tmp_path / "failures.png")).shape == (258, 1280, 3)
    hand = detector.detect(np.full((64, 128, 3), 90, np.uint8))
    assert mistakes(PictureResult(hand, hand)) == 0
    assert mistakes(PictureResult([], hand)) == 1
    assert mistakes(PictureResult([], hand, hand)) == 0
    assert mistakes(PictureResult([Region("Foot_skin", 1.0, hand[0].box)], hand)) == 2


def test_the_training_summary_is_read_from_the_log(tmp_path):
    with pytest.raises(SettingsError, match="there is no"):
        training_summary(tmp_path)
    (tmp_path / "training.csv").write_text(
        "step,minutes,images_per_s\n50,0.4,15.0\n100,1.2,5.0\n150,1.6,14.0\n"
    )
    assert training_summary(tmp_path).startswith("150 steps in 2 minutes of training; 14.0 pictures/s")
