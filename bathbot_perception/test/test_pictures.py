import numpy as np
import pytest
from bathbot_perception.errors import PictureError
from bathbot_perception.pictures import pictures
from bathbot_perception.pictures.pictures import read_picture
from PIL import Image

RAMP = np.tile(np.arange(64, dtype=np.uint8)[:, None] * 4, (1, 48))


def test_a_colour_picture_is_read_as_it_is(tmp_path):
    rgb = np.random.default_rng(0).integers(0, 256, (40, 50, 3), dtype=np.uint8)
    Image.fromarray(rgb).save(tmp_path / "a.png")
    picture = read_picture(tmp_path / "a.png")
    assert np.array_equal(picture.rgb, rgb)
    assert picture.note == ""


@pytest.mark.parametrize(
    ("image", "note"),
    [
        pytest.param(Image.fromarray(RAMP), "greyscale", id="greyscale"),
        pytest.param(Image.fromarray(RAMP.astype(np.uint16) * 257), "16-bit", id="16-bit"),
        pytest.param(Image.fromarray(np.dstack([RAMP] * 4)), "transparency", id="alpha"),
        pytest.param(Image.fromarray(RAMP).convert("P"), "", id="palette"),
        pytest.param(Image.new("RGB", (48, 64)), "all black", id="black"),
        pytest.param(Image.new("RGBA", (48, 64), (255, 0, 0, 0)), "transparency", id="clear"),
    ],
)
def test_unusual_pictures_become_colour_with_a_note(tmp_path, image, note):
    image.save(tmp_path / "a.png")
    picture = read_picture(tmp_path / "a.png")
    assert picture.rgb.shape == (64, 48, 3)
    assert picture.rgb.dtype == np.uint8
    assert note in picture.note


def test_16_bits_are_scaled_not_cut(tmp_path):
    Image.fromarray(RAMP.astype(np.uint16) * 257).save(tmp_path / "a.png")
    assert np.array_equal(read_picture(tmp_path / "a.png").rgb[..., 0], RAMP)


def test_a_turned_photo_is_read_upright(tmp_path):
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.new("RGB", (64, 48)).save(tmp_path / "a.jpg", exif=exif)
    assert read_picture(tmp_path / "a.jpg").rgb.shape == (64, 48, 3)


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_a_truncated_file_is_refused(tmp_path, suffix):
    path = tmp_path / f"cut{suffix}"
    Image.fromarray(np.random.default_rng(0).integers(0, 256, (90, 90, 3), dtype=np.uint8)).save(path)
    path.write_bytes(path.read_bytes()[:-2000])
    with pytest.raises(PictureError, match=r"cannot read .*cut") as caught:
        read_picture(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content", [b"", b"hello", b"\xff\xd8\xff\xe0"], ids=["empty", "text", "header only"]
)
def test_a_file_that_is_no_picture_is_refused(tmp_path, content):
    (tmp_path / "a.jpg").write_bytes(content)
    with pytest.raises(PictureError, match="cannot read"):
        read_picture(tmp_path / "a.jpg")


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(PictureError, match="No such file"):
        read_picture(tmp_path / "none.jpg")


def test_tiny_and_huge_pictures_are_refused_before_decoding(tmp_path, monkeypatch):
    Image.new("RGB", (1, 1)).save(tmp_path / "tiny.png")
    with pytest.raises(PictureError, match="1x1 px; a side must have at least 16"):
        read_picture(tmp_path / "tiny.png")
    Image.new("RGB", (2000, 1000)).save(tmp_path / "huge.png")
    monkeypatch.setattr(pictures, "MOST_PIXELS", 1_000_000)
    with pytest.raises(PictureError, match="2000x1000 px, over 1 million"):
        read_picture(tmp_path / "huge.png")
