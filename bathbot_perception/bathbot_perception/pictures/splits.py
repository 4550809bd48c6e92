"""Which pictures of a data set train, validate and test; no picture does two of them."""

import hashlib
from pathlib import Path
from typing import NamedTuple

from bathbot_perception.pictures.voc import Sample, list_samples, read_checked


class Split(NamedTuple):
    """Pictures of one data set by use."""

    train: list[Sample]
    val: list[Sample]
    test: list[Sample]


def split_samples(folder: Path, shares: tuple[float, float] = (0.2, 0.2)) -> Split:
    """Split a data set by a hash of each picture's name, so that added pictures move no other.

    Only checked pictures (see `voc.read_checked`) may validate or test.

    Args:
        folder: Data set with `images/` and `annotations/`.
        shares: Shares of the checked pictures that validate and that test.
    """
    checked = read_checked(folder)
    split = Split([], [], [])
    for sample in list_samples(folder):
        digest = hashlib.sha256(sample.picture.stem.encode()).digest()
        draw = int.from_bytes(digest[:4], "big") / 2**32
        if sample.picture.stem not in checked or draw >= sum(shares):
            split.train.append(sample)
        elif draw < shares[0]:
            split.val.append(sample)
        else:
            split.test.append(sample)
    return split
