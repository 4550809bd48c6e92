import cv2
import numpy as np
import pytest
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import AnnotationError
from bathbot_perception.pictures.splits import split_samples
from bathbot_perception.pictures.voc import (
    Annotation,
    list_samples,
    read_annotation,
    read_checked,
    write_annotation,
)
from bathbot_perception.regions import Region
from hypothesis import given
from hypothesis import strategies as st

hundredths = st.integers(0, 9000).map(lambda n: n / 100)
regions = st.builds(
    lambda name, left, top, width, height: Region(name, 1.0, (left, top, left + width + 1, top + height + 1)),
    st.sampled_from(SKIN_CLASSES), hundredths, hundredths, hundredths, hundredths,
)  # fmt: skip


@given(st.lists(regions, max_size=6), st.lists(regions, max_size=3))
def test_an_annotation_survives_the_file(tmp_path_factory, plain, difficult):
    path = tmp_path_factory.getbasetemp() / "one.xml"
    annotation = Annotation("one.jpg", 200, 300, tuple(plain), tuple(difficult))
    write_annotation(path, annotation)
    again = read_annotation(path)
    assert again[:3] == annotation[:3]
    for read, written in ((again.regions, plain), (again.difficult, difficult)):
        assert [r.name for r in read] == [r.name for r in written]
        for ours, theirs in zip(read, written, strict=True):
            assert ours.box == pytest.approx(theirs.box, abs=0.006)


def voc(name="Hand_skin", box=(1, 2, 30, 40), size="<size><width>100</width><height>50</height></size>"):
    corners = "".join(f"<{k}>{v}</{k}>" for k, v in zip(("xmin", "ymin", "xmax", "ymax"), box, strict=True))
    return f"<annotation>{size}<object><name>{name}</name><bndbox>{corners}</bndbox></object></annotation>"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        pytest.param("<annotation>", "no element found", id="truncated"),
        pytest.param("", "no element found", id="empty"),
        pytest.param(voc(size=""), "it has no <size/width>", id="no size"),
        pytest.param(voc(name="Elbow"), "unknown class 'Elbow'", id="unknown class"),
        pytest.param(voc(box=(30, 2, 30, 40)), "empty or outside", id="empty box"),
        pytest.param(voc(box=(130, 2, 150, 40)), "empty or outside", id="box outside"),
        pytest.param(voc(box=("a", 2, 30, 40)), "could not convert", id="no number"),
        pytest.param(
            voc(name="Hand_skin</name><difficult>yes</difficult><name>"),
            "<difficult> is 'yes'",
            id="difficult",
        ),
        pytest.param(
            voc(size="<size><width>0</width><height>5</height></size>"), "its size is 0x5", id="no pixels"
        ),
    ],
)
def test_bad_files_are_refused_on_one_line(tmp_path, text, reason):
    path = tmp_path / "bad.xml"
    path.write_text(text)
    with pytest.raises(AnnotationError, match=reason) as caught:
        read_annotation(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_boxes_are_cut_at_the_border_and_background_is_no_region(tmp_path):
    path = tmp_path / "a.xml"
    path.write_text(voc(box=(-5, 2, 130, 40)))
    assert read_annotation(path).regions[0].box == (0.0, 2.0, 100.0, 40.0)
    path.write_text(voc(name="Hand_skin</name><difficult/><name>"))
    assert (len(read_annotation(path).regions), len(read_annotation(path).difficult)) == (1, 0)
    path.write_text(voc(name="Background"))
    assert read_annotation(path).regions == ()


@pytest.fixture
def data_set(tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "annotations").mkdir()
    for index in range(60):
        cv2.imwrite(str(tmp_path / f"images/{index:02}.png"), np.zeros((50, 100, 3), np.uint8))
        (tmp_path / f"annotations/{index:02}.xml").write_text(voc())
    return tmp_path


def test_pictures_are_paired_with_their_boxes(data_set):
    samples = list_samples(data_set)
    assert [s.picture.stem for s in samples] == [s.annotation.stem for s in samples]
    assert len(samples) == 60


def test_a_picture_without_boxes_file_is_named(data_set):
    (data_set / "annotations/07.xml").unlink()
    with pytest.raises(AnnotationError, match=r"1 pictures .* the first is 07\.png"):
        list_samples(data_set)


def test_folders_that_are_no_data_set_are_refused(tmp_path):
    with pytest.raises(AnnotationError, match="no folder images/"):
        list_samples(tmp_path)
    (tmp_path / "images").mkdir()
    (tmp_path / "annotations").mkdir()
    with pytest.raises(AnnotationError, match="holds no picture"):
        list_samples(tmp_path)


def test_a_split_is_a_partition_that_new_pictures_do_not_move(data_set):
    before = split_samples(data_set)
    stems = [s.picture.stem for part in before for s in part]
    assert sorted(stems) == [f"{i:02}" for i in range(60)]
    assert 4 <= len(before.val) <= 20
    assert 4 <= len(before.test) <= 20
    cv2.imwrite(str(data_set / "images/99.png"), np.zeros((50, 100, 3), np.uint8))
    (data_set / "annotations/99.xml").write_text(voc())
    after = split_samples(data_set)
    assert all(set(old) <= set(new) for old, new in zip(before, after, strict=True))


def test_only_checked_pictures_validate_and_test(data_set):
    (data_set / "checked.txt").write_text("\n".join(f"{i:02}.png" for i in range(30)))
    split = split_samples(data_set)
    assert {s.picture.stem for s in (*split.val, *split.test)} <= read_checked(data_set)
    assert len(split.train) + len(split.val) + len(split.test) == 60
