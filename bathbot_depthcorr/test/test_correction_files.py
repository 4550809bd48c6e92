"""Files that are no depth correction are refused in one line."""

import numpy as np
import pytest
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.files import CalibrationFileError
from correction_makers import spline


class TestForeignFiles:
    def refused(self, path, words):
        with pytest.raises(CalibrationFileError, match=words) as caught:
            load(path)
        assert "\n" not in str(caught.value)

    def test_missing(self, tmp_path):
        self.refused(tmp_path / "absent.npz", "no depth calibration at .*absent.npz; make one with")

    def test_empty_text_and_folder(self, tmp_path):
        (tmp_path / "empty.npz").write_bytes(b"")
        self.refused(tmp_path / "empty.npz", r"\(0 bytes\) is no depth calibration")
        (tmp_path / "text.npz").write_text("hello")
        self.refused(tmp_path / "text.npz", "is no depth calibration")
        self.refused(tmp_path, "cannot read")

    def test_cut_off_anywhere(self, tmp_path):
        spline().save(tmp_path / "whole.npz")
        data = (tmp_path / "whole.npz").read_bytes()
        for share in (0.1, 0.5, 0.9, 0.99):
            (tmp_path / "cut.npz").write_bytes(data[: int(share * len(data))])
            self.refused(tmp_path / "cut.npz", "is cut off")

    def test_single_array(self, tmp_path):
        np.save(tmp_path / "array.npy", np.zeros(3))
        self.refused(tmp_path / "array.npy", "is no depth calibration")

    def test_other_npz(self, tmp_path):
        np.savez(tmp_path / "other.npz", x=1)
        self.refused(tmp_path / "other.npz", "format 'none', expected 'bathbot depth correction 1'")

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            (
                {"model": "wizard"},
                "model 'wizard', known are disparity_spline, two_stage, two_imager, identity",
            ),
            ({"T_colour_depth": np.eye(3)}, "lacks or garbles"),
            ({"size": np.array([0, 0])}, "describe no camera"),
            ({"ripple": np.full(4, np.nan)}, "not finite"),
            ({"scale": np.zeros(3)}, "lacks or garbles"),
            ({"offset": None}, "lacks or garbles a value: 'offset'"),
        ],
    )
    def test_garbled_values(self, tmp_path, change, words):
        spline().save(tmp_path / "unit.npz")
        with np.load(tmp_path / "unit.npz") as file:
            contents = dict(file)
        contents = {key: value for key, value in {**contents, **change}.items() if value is not None}
        np.savez(tmp_path / "unit.npz", **contents)
        self.refused(tmp_path / "unit.npz", words)

    def test_nothing_is_left_where_nothing_can_be_written(self, tmp_path):
        with pytest.raises(CalibrationFileError, match="cannot write"):
            spline().save(tmp_path / "no" / "folder.npz")
        assert not list(tmp_path.iterdir())
