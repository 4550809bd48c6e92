import csv

import cv2
import numpy as np
import pytest
from bathbot_perception.detection.detector import load
from bathbot_perception.pictures.detect_files import detect_files
from bathbot_perception.pictures.draw import draw_regions
from bathbot_perception.regions import Region
from tiny_model import row


@pytest.fixture
def detector(write_model):
    return load(write_model([row("Hand_skin", 0.9, (32.0, 32.0), (16.0, 8.0))]))


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "pictures"
    path.mkdir()
    for name in ("a.png", "b.jpg"):
        cv2.imwrite(str(path / name), np.full((64, 64, 3), 200, np.uint8))
    (path / "broken.jpg").write_bytes(b"no picture")
    (path / "notes.txt").write_text("left out")
    return path


def test_a_folder_is_drawn_and_listed_and_a_broken_file_does_not_stop_it(detector, folder, tmp_path):
    out = tmp_path / "out"
    results = list(detect_files([folder], detector, out))
    assert [r.source.name for r in results] == ["a.png", "b.jpg", "broken.jpg"]
    assert [len(r.regions) for r in results] == [1, 1, 0]
    assert [bool(r.error) for r in results] == [False, False, True]
    assert sorted(p.name for p in out.iterdir()) == ["a.jpg", "b.jpg", "regions.csv"]
    with (out / "regions.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [r["class"] for r in rows] == ["Hand_skin", "Hand_skin"]
    assert float(rows[0]["left"]) == pytest.approx(24.0)


def test_files_of_one_name_do_not_overwrite_each_other(detector, folder, tmp_path):
    list(detect_files([folder / "a.png", folder / "a.png"], detector, tmp_path / "out"))
    assert (tmp_path / "out/a.jpg").is_file()
    assert (tmp_path / "out/a-2.jpg").is_file()


def test_without_an_output_folder_nothing_is_written(detector, folder):
    before = sorted(folder.iterdir())
    assert len(list(detect_files([folder], detector))) == 3
    assert sorted(folder.iterdir()) == before


def test_every_frame_of_a_film_is_searched(detector, tmp_path):
    path = tmp_path / "film.avi"
    film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (64, 64))
    for _ in range(5):
        film.write(np.full((64, 64, 3), 128, np.uint8))
    film.release()
    results = list(detect_files([path], detector, tmp_path / "out"))
    assert [r.frame for r in results] == [0, 1, 2, 3, 4]
    assert cv2.VideoCapture(str(tmp_path / "out/film.mp4")).get(cv2.CAP_PROP_FRAME_COUNT) == 5


def test_a_file_that_is_no_film_is_named(detector, tmp_path):
    (tmp_path / "film.mp4").write_bytes(b"no film")
    (result,) = detect_files([tmp_path / "film.mp4"], detector)
    assert "cannot read" in result.error


def test_drawing_leaves_the_picture_alone():
    picture = np.zeros((64, 64, 3), np.uint8)
    drawn = draw_regions(picture, [Region("Face_skin", 0.5, (10.0, 20.0, 40.0, 60.0))])
    assert picture.max() == 0
    assert drawn.shape == picture.shape
    assert drawn[60, 25].max() > 0
