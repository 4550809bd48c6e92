"""What was lost on the way: publishers count what they send, so a gap tells of messages that never came."""


class SenderCounts:
    """Remembers the newest number of each publisher."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._newest: dict[tuple[str, bytes], int] = {}

    def missed(self, topic: str, publisher: bytes, number: int) -> int:
        """How many messages lie between the one before and this one; what came before the first counts not.

        Args:
            topic: The topic.
            publisher: Which of its publishers.
            number: Its count of this message; a middleware that does not count says 0.
        """
        before = self._newest.get((topic, publisher), number - 1)
        self._newest[topic, publisher] = max(number, before)
        return max(number - before - 1, 0)
