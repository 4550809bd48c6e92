"""How a calibration tells what it is doing; a terminal may show more than lines."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext


class Steps:
    """Hears how a calibration goes; this one hands each line to a function and shows no bars."""

    def __init__(self, tell: Callable[[str], None] = lambda _: None) -> None:
        """Remember whom to tell.

        Args:
            tell: Called with one line at a time.
        """
        self._tell = tell

    def stage(self, name: str, about: str) -> AbstractContextManager[None]:
        """Wrap a stage of the job: its short name and what it does."""
        self._tell(about)
        return nullcontext()

    def note(self, text: str) -> None:
        """Take one line about the running stage."""
        self._tell(text)

    def progress(self, fraction: float, detail: str) -> None:
        """Hear how much of the running stage is done, 0..1, and of what."""
