"""Errors of this package; each message says what is wrong, the value seen, and what to try."""

from bathbot_depthcorr.errors import BathbotError


class BringupError(BathbotError):
    """Base of this package's errors."""


class SettingsError(BringupError):
    """A parameter outside its meaning."""


class InputError(BringupError):
    """Something the user named does not exist or is not what the command needs."""


class BagError(InputError):
    """A bag that cannot be read, or that lacks what is asked of it."""


class ReplayError(BringupError):
    """A replay that is not what was recorded."""


class ProcessError(BringupError):
    """A process of the graph did not start, or died.

    Attributes:
        node: Name of the node whose process failed.
        last_line: The last line it wrote; empty when it wrote none.
        exit_code: Of the process; None while it runs, negative after a signal, 2 after bad input.
    """

    def __init__(self, node: str, what: str, last_line: str, log: str, exit_code: int | None = None) -> None:
        """Keep the evidence; `what` is a verb phrase such as "ended with exit code 2", `log` a path."""
        self.node, self.last_line, self.exit_code = node, last_line, exit_code
        said = f"; its last line: {last_line}" if last_line else "; it wrote nothing"
        super().__init__(f"node {node} {what}{said}; read {log}")


class StepError(BringupError):
    """A step of the bathing job did not succeed.

    Attributes:
        step: Name of the step.
    """

    def __init__(self, step: str, reason: str) -> None:
        """Keep the name of the step that failed."""
        self.step = step
        super().__init__(f"{step} failed: {reason}")
