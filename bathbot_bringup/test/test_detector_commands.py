"""The commands about the skin detector, from the command line to their files."""

import json

import cv2
import numpy as np
import onnx
import pytest
from bathbot_bringup.command.cli import run
from bathbot_perception.evaluation.conditions import CONDITIONS, STRENGTHS
from bathbot_perception.pictures.voc import Annotation, Region, write_annotation


@pytest.fixture
def data_set(tmp_path):
    """A grey picture, said to show a hand."""
    folder = tmp_path / "data"
    for name in ("images", "annotations"):
        (folder / name).mkdir(parents=True)
    cv2.imwrite(str(folder / "images" / "0.png"), np.full((96, 128, 3), 120, np.uint8))
    regions = (Region("Hand_skin", 1.0, (10.0, 20.0, 60.0, 70.0)),)
    write_annotation(folder / "annotations" / "0.xml", Annotation("0.png", 128, 96, regions))
    return folder


def test_the_evaluation_writes_the_agreed_keys(data_set, tmp_path, capsys):
    file = tmp_path / "detector.json"
    assert run(["evaluate", "detector", str(data_set), "--json", str(file)]) == 0
    numbers = json.loads(file.read_text())
    assert {"map50", "map50_95", "ap50", "images", "ms_per_image_p50", "conditions"} <= set(numbers)
    assert numbers["images"] == 1
    assert set(numbers["conditions"]) == {*CONDITIONS, "skin_tone"}
    assert all(set(numbers["conditions"][name]) == set(STRENGTHS) for name in CONDITIONS)
    shown = capsys.readouterr().out
    for title in ("what is taken for what", "conditions", "skin.onnx on 1 pictures"):
        assert title in shown


def test_the_int8_model_is_meant_by_its_name(data_set, capsys):
    arguments = ["--conditions", "none", "--model", "skin_int8.onnx"]
    assert run(["evaluate", "detector", str(data_set), *arguments]) == 0
    assert "skin_int8.onnx on 1 pictures" in capsys.readouterr().out


def test_an_unknown_condition_is_said(data_set, capsys):
    assert run(["evaluate", "detector", str(data_set), "--conditions", "hail"]) == 2
    assert "unknown condition 'hail'; known are steam" in capsys.readouterr().err


def test_the_bench_writes_the_agreed_keys(tmp_path, capsys):
    file = tmp_path / "bench.json"
    assert run(["bench", "detector", "--rounds", "10", "--size", "128", "--json", str(file)]) == 0
    numbers = json.loads(file.read_text())
    assert {"fps", "node_over_runtime", "int8_over_fp32", "size_px", "threads"} <= set(numbers)
    assert numbers["size_px"] == 128
    assert numbers["fps"] > 0
    assert "INT8 is" in capsys.readouterr().out


def test_a_model_is_exported_for_one_shape(tmp_path, capsys):
    file = tmp_path / "for" / "tensorrt.onnx"
    assert run(["export", "detector", "--precision", "fp16", "--shape", "128x96", "--out", str(file)]) == 0
    shape = [item.dim_value for item in onnx.load(file).graph.input[0].type.tensor_type.shape.dim]
    assert shape == [1, 3, 96, 128]
    assert "opset 13, input 128x96 px only" in capsys.readouterr().out


def test_a_region_is_looked_for_in_the_simulated_bathroom(tmp_path, capsys):
    file = tmp_path / "regions.json"
    assert run(["evaluate", "regions", "--seeds", "0", "--json", str(file)]) == 0
    numbers = json.loads(file.read_text())
    assert (numbers["found"], numbers["region"]) == (1, "Trunk_skin")
    assert 0.5 <= numbers["seeds"][0]["overlap"] <= 1.0
    assert "Trunk_skin found for 1 of 1 seeds" in capsys.readouterr().out
