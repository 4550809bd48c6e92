"""Files are written whole or not at all, with the reason in one line."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest
from bathbot_depthcorr.files import CalibrationFileError, write_atomically, write_npz


@pytest.mark.parametrize(("content", "data"), [("größer\n", "größer\n".encode()), (b"\x00\xff", b"\x00\xff")])
def test_text_and_bytes_replace_the_old_file(tmp_path, content, data):
    target = tmp_path / "a.txt"
    target.write_text("old")
    write_atomically(target, content)
    assert target.read_bytes() == data
    assert target.stat().st_mode & 0o777 == 0o600
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]


@pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError(errno.ENOSPC, "No space left on device")])
def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, error):
    target = tmp_path / "a.txt"
    target.write_text("old")

    def fail(*_):
        raise error

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(type(error)):
        write_atomically(target, "new")
    assert target.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]


def test_a_missing_folder_is_not_made(tmp_path):
    with pytest.raises(FileNotFoundError):
        write_atomically(tmp_path / "no" / "a.txt", "new")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("number", "advice"), [
    (errno.ENOSPC, "is the disk full?"), (errno.EACCES, "choose another folder"),
])  # fmt: skip
def test_arrays_that_cannot_be_written_are_told_with_advice(tmp_path, monkeypatch, number, advice):
    def fail(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(CalibrationFileError) as caught:
        write_npz(tmp_path / "a.npz", {"x": np.zeros(3)})
    assert str(caught.value) == f"cannot write {tmp_path / 'a.npz'}: {os.strerror(number)}; {advice}"
