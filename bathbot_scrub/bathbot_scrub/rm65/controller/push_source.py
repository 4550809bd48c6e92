"""Whose datagrams are the state push: one address, one port, and no more of them than were ordered.

The push carries neither number nor stamp nor key, so this is what can be asked. Pure; time is an argument.
"""

LEARN = 0.2  # [s] for which senders are listened to before one is believed
_BURST = 100  # datagrams that may come at once: half a second of them waited for a process that was held up
_LENIENT = 1.05  # a controller's clock is not ours


class PushSource:
    """Learns the controller's port after every set-up, and then believes no other.

    Attributes:
        believed: Address and port; None before it is known.
        trouble: Why nobody is believed; empty when that is only a matter of time.
    """

    def __init__(self, learn: float = LEARN) -> None:
        """Believe nobody; `learn` [s] is the time for which all senders are looked at."""
        self.believed: tuple[str, int] | None = None
        self.trouble = ""
        self._learn, self._address = learn, ""
        self._ports: set[int] = set()
        self._since: float | None = None  # [s] of the first datagram

    @property
    def learning(self) -> bool:
        """Whether senders are being looked at."""
        return self.believed is None and self._since is not None and not self.trouble

    def expect(self, address: str) -> None:
        """The push has been ordered: learn anew from which port of `address` it comes."""
        self.believed, self.trouble, self._address = None, "", address
        self._ports, self._since = set(), None

    def believes(self, sender: tuple[str, int], now: float) -> bool:
        """Whether a datagram that came at `now` [s] is the controller's."""
        if self.believed is not None:
            return sender == self.believed
        if sender[0] != self._address:
            return False
        self._ports.add(sender[1])
        self._since = now if self._since is None else self._since
        if len(self._ports) > 1:
            ports = " and ".join(str(port) for port in sorted(self._ports)[:2])
            self.trouble = f"two programs at {self._address} send states, from ports {ports}: end one of them"
            return False
        if now - self._since < self._learn:
            return False
        self.believed = sender
        return True


class PushRate:
    """Counts datagrams against what was ordered."""

    def __init__(self, rate: float) -> None:
        """Allow `rate` [Hz] in the long run."""
        self._rate, self._left = _LENIENT * rate, float(_BURST)
        self._last: float | None = None

    def exceeded(self, now: float) -> bool:
        """Whether a datagram that comes at `now` [s] is one too many."""
        since = 0.0 if self._last is None else max(now - self._last, 0.0)
        self._left, self._last = min(self._left + since * self._rate, _BURST), now
        if self._left < 1.0:
            return True
        self._left -= 1.0
        return False
