"""What may stand in a message that is recorded without a picture: so much of each thing, and no disguise.

A picture can be sent as any type: as bytes, as a long text, as the floats of a path. So texts are short and
made of words, lists are short, and numbers are such as are measured: raw bytes read as floats mostly are not.
"""

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np

_LARGEST, _SMALLEST = 1e7, 1e-30  # of what is measured in SI units; times are integers
_WORD = re.compile(r"\S{81,}")  # longer than any path or sentence without a space
_NOT_TEXT = re.compile(r"[^\t\n\r -~\u00a0-\u024f\u0370-\u03ff\u2010-\u2027\u2190-\u21ff\u2200-\u22ff]")
_NAN = {struct.pack("<d", sign * float("nan")) for sign in (1.0, -1.0)}
KNOWN = ("robot_description",)
"""Names of long texts that hide nothing, because they are ours to the letter."""


@cache
def _known(name: str) -> frozenset[str]:
    from bathbot_scrub.installed_arm import descriptions  # takes a second, and not every recording needs it

    return {KNOWN[0]: descriptions}[name]()


@dataclass(frozen=True, slots=True)
class Bounds:
    """Of one message.

    Attributes:
        size: Of the whole [bytes].
        text: Of each text [characters].
        items: Of each list.
        known: Names long texts of ours that may stand there, too; see `KNOWN`.
    """

    size: int
    text: int
    items: int
    known: str = ""

    def refusal(self, message: Any) -> str:
        """Why a decoded message may not be recorded; empty when it may."""
        return self._of(message, type(message).__name__)

    def _of(self, value: Any, place: str) -> str:
        if isinstance(value, str):
            return self._of_text(value, place)
        if isinstance(value, np.ndarray):
            return self._of_numbers(value, place)
        if isinstance(value, float):
            return _of_number(value, place)
        if is_dataclass(value):
            parts = ((getattr(value, one.name), one.name) for one in fields(value) if one.name[:2] != "__")
            return next(filter(None, (self._of(part, f"{place}.{name}") for part, name in parts)), "")
        if isinstance(value, Sequence):
            if len(value) > self.items:
                return f"{place} has {len(value)} entries, more than {self.items}"
            return next(filter(None, (self._of(part, place) for part in value)), "")
        return ""

    def _of_text(self, text: str, place: str) -> str:
        if self.known and text in _known(self.known):
            return ""
        if len(text) > self.text:
            return f"{place} is a text of {len(text)} characters, more than {self.text}"
        if _NOT_TEXT.search(text) or _WORD.search(text):
            return f"{place} holds what no person writes"
        return ""

    def _of_numbers(self, numbers: np.ndarray, place: str) -> str:
        if numbers.size > self.items:
            return f"{place} has {numbers.size} entries, more than {self.items}"
        if numbers.dtype.kind == "f":
            return next(filter(None, (_of_number(float(one), place) for one in numbers)), "")
        return ""


def _of_number(number: float, place: str) -> str:
    if number != number:
        return "" if struct.pack("<d", number) in _NAN else f"{place} hides something in what is no number"
    if number in (0.0, float("inf"), float("-inf")) or _SMALLEST < abs(number) < _LARGEST:
        return ""
    return f"{place} is {number:.3g}, which nobody measures"
