import csv

import cv2
import numpy as np
import pytest
from bags import write_bag
from bathbot_bringup.command.cli import run
from bathbot_depthcorr.ros.messages import image_from_colour
from skimage import data
from std_msgs.msg import Header


@pytest.fixture
def portrait(tmp_path):
    """A photograph in the public domain: Eileen Collins, by NASA."""
    file = tmp_path / "portrait.png"
    cv2.imwrite(str(file), data.astronaut()[..., ::-1])
    return file


def rows(folder):
    with (folder / "regions.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_photograph_is_drawn_and_listed(tmp_path, portrait, capsys):
    assert run(["detect", str(portrait), "--out", str(tmp_path / "out"), "--score", "0.05"]) == 0
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"portrait.jpg", "regions.csv"}
    assert cv2.imread(str(tmp_path / "out" / "portrait.jpg")).shape == (512, 512, 3)
    assert "portrait.png" in capsys.readouterr().out


def test_a_folder_a_bag_and_a_broken_file_in_one_go(tmp_path, portrait, capsys):
    folder = tmp_path / "folder"
    folder.mkdir()
    portrait.rename(folder / "portrait.png")
    message = image_from_colour(np.ascontiguousarray(data.astronaut()), Header())
    topic = ("/camera/camera/color/image_raw", "sensor_msgs/msg/Image")
    write_bag(tmp_path / "bag", [(*topic, index + 1, message) for index in range(3)])
    (tmp_path / "broken.jpg").write_bytes(b"nothing")
    paths = [folder, tmp_path / "broken.jpg", tmp_path / "bag"]
    assert run(["detect", *map(str, paths), "--out", str(tmp_path / "out"), "--every", "2"]) == 2
    assert "broken.jpg" in capsys.readouterr().err
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert names == {"portrait.jpg", "bag-00000.jpg", "bag-00002.jpg", "regions.csv"}
    assert {row["frame"] for row in rows(tmp_path / "out")} <= {"-1", "0", "2"}


def test_a_bag_without_pictures_says_how_to_record_some(tmp_path, capsys):
    write_bag(tmp_path / "bag", [])
    assert run(["detect", str(tmp_path / "bag"), "--out", str(tmp_path / "out")]) == 2
    assert "holds no colour pictures" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_an_empty_folder_says_what_is_looked_for(tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert run(["detect", str(tmp_path / "empty"), "--out", str(tmp_path / "out")]) == 2
    assert "holds no picture and no film; known endings are .jpg" in capsys.readouterr().err
