"""Files from strangers: small ones that would become gigabytes, or hang, are refused at once."""

import io
import zipfile

import numpy as np
import pytest
import yaml
from bathbot_depthcorr.bounded_files import parse_yaml, read_npz, read_yaml

LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n"
    for old, new in zip("abcdefghij", "bcdefghijk", strict=True)
)


def test_what_is_plain_is_read(tmp_path):
    (tmp_path / "x.yaml").write_text("a: [1, 2.5, {b: text}]\n")
    assert read_yaml(tmp_path / "x.yaml") == {"a": [1, 2.5, {"b": "text"}]}
    np.savez_compressed(tmp_path / "x.npz", a=np.arange(3), b="text")
    assert set(read_npz(tmp_path / "x.npz")) == {"a", "b"}


@pytest.mark.parametrize(("text", "said"), [
    pytest.param(LAUGHS, "more than 50000 parts", id="a billion laughs"),
    pytest.param("a: &a [*a]", "more than 50000 parts", id="holds itself"),
    pytest.param("[" * 30 + "]" * 30, "deeper", id="nested"),
    pytest.param("[" * 100_000, "deeper", id="nested without end"),
    pytest.param("!!python/object/apply:os.system [true]", "could not determine a constructor", id="code"),
    pytest.param("a: b: c", "mapping values", id="no YAML"),
])  # fmt: skip
def test_what_unfolds_or_runs_is_refused(text, said):
    with pytest.raises(yaml.YAMLError, match=said):
        parse_yaml(text)


def test_a_part_may_be_named_twice():
    assert parse_yaml("a: &one {b: 1}\nc: *one\n") == {"a": {"b": 1}, "c": {"b": 1}}


def test_a_text_too_large_is_refused(tmp_path):
    (tmp_path / "x.yaml").write_text("- a\n" * 100_000)
    with pytest.raises(yaml.YAMLError, match="larger than 256 kB"):
        read_yaml(tmp_path / "x.yaml")


def test_an_archive_that_unfolds_to_gigabytes_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "x.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        for number in range(3):
            with archive.open(f"{number}.npy", "w") as part:
                for _ in range(18):
                    part.write(bytes(10 << 20))
    assert (tmp_path / "x.npz").stat().st_size < 1 << 20
    with pytest.raises(ValueError, match="unfolds to 540 MB"):
        read_npz(tmp_path / "x.npz")


def test_pickled_objects_are_refused(tmp_path):
    packed = io.BytesIO()
    np.savez(packed, a=np.array([{"a": 1}], dtype=object))
    (tmp_path / "x.npz").write_bytes(packed.getvalue())
    with pytest.raises(ValueError, match="allow_pickle"):
        read_npz(tmp_path / "x.npz")
