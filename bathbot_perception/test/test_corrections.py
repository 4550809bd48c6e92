"""Corrections of labels: what a file may say, and that training takes its boxes."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from bathbot_perception.errors import AnnotationError
from bathbot_perception.pictures.voc import Annotation, Region, list_samples, write_annotation
from bathbot_perception.training.data.corrections import read_corrections
from bathbot_perception.training.data.dataset import load_source

OURS = Path(__file__).parents[1] / "labels" / "real_skin.json"


@pytest.fixture
def folder(tmp_path):
    """Three pictures with a face each."""
    for name in ("images", "annotations"):
        (tmp_path / name).mkdir()
    for stem in "abc":
        cv2.imwrite(str(tmp_path / "images" / f"{stem}.png"), np.full((60, 40, 3), 90, np.uint8))
        regions = (Region("Face_skin", 1.0, (5.0, 5.0, 20.0, 25.0)),)
        write_annotation(tmp_path / "annotations" / f"{stem}.xml", Annotation(f"{stem}.png", 40, 60, regions))
    (tmp_path / "checked.txt").write_text("c.png\n")
    return tmp_path


def test_training_takes_corrected_boxes_and_leaves_pictures_out(folder):
    file = folder / "better.json"
    file.write_text(json.dumps({"a.png": [["Hand_skin", 1, 2, 30, 50]], "b.png": None}))
    source = load_source(folder, list_samples(folder), 60, read_corrections(file))
    assert len(source.examples) == 2
    assert source.examples[0].boxes.tolist() == [[1, 2, 30, 50]]
    assert source.examples[0].classes.tolist() == [4]
    assert source.examples[1].boxes.tolist() == [[5, 5, 20, 25]]
    plain = load_source(folder, list_samples(folder), 60)
    assert plain.chances[0] < plain.chances[2]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"a.png": [["Nose", 1, 2, 3, 4]]}',
        '{"a.png": [["Hand_skin", 3, 2, 1, 4]]}',
        '{"a.png": [["Hand_skin", 3]]}',
        '{"a.png": 3}',
        '{"a.png": [["Hand_skin", "x", 2, 3, 4]]}',
    ],
)
def test_a_file_of_another_form_is_refused_with_its_name(tmp_path, text):
    file = tmp_path / "bad.json"
    file.write_text(text)
    with pytest.raises(AnnotationError, match=r"bad\.json as corrections"):
        read_corrections(file)


def test_the_corrections_of_the_project_can_be_read():
    listed = read_corrections(OURS)
    assert len(listed) == 253
    assert sum(len(boxes) for boxes in listed.values() if boxes is not None) > 800
