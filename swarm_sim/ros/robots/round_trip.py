"""Time to wait for an answer before it is asked for again. No clock, no I/O.

RFC 6298: a smoothed time and its mean deviation, Karn's rule (an answer to what was sent twice says
nothing about the time, unless it came so soon after the repeat that it must answer the first), and
a limit that doubles with each repeat and stays so until an answer tells the time. A fixed period is
too long where one datagram got lost, and floods a narrow link.
"""

from __future__ import annotations

GAIN, DEVIATION_GAIN, DEVIATIONS = 1 / 8, 1 / 4, 4.0  # alpha, beta and K of RFC 6298
FIRST = 0.25  # [s] before anything is known
FASTEST = 0.5  # share of the usual time in which no answer comes
LEAST = 0.01  # [s] between hosts: what the operating system's waits are good for
LONGEST = 1.0  # [s] so that a link that comes back is used soon


class RoundTrip:
    """Round trip to one robot.

    Attributes:
        limit: [s] after which its answer is asked for again.
        is_hurried: Whether it was sent again before its time.
    """

    def __init__(self, least: float, longest: float = LONGEST) -> None:
        """Start without a measured round trip."""
        self.limit = max(FIRST, least)
        self._least, self._longest = least, longest
        self._smooth: float | None = None
        self._deviation = 0.0
        self._first_at = self._sent_at = 0.0
        self.is_hurried = False

    def send(self, now: float) -> None:
        """Record that something was sent for the first time."""
        self._first_at = self._sent_at = now
        self.is_hurried = False

    def hurry(self, now: float) -> None:
        """Record that it was sent again before its time, as most others have answered."""
        self._sent_at = now
        self.is_hurried = True

    def repeat(self, now: float) -> None:
        """Record that it was sent again; the limit doubles."""
        self._sent_at = now
        self.limit = min(2.0 * self.limit, self._longest)

    @property
    def due_at(self) -> float:
        """Wall time at which the answer is to be asked for again."""
        return self._sent_at + self.limit

    def answer(self, now: float) -> None:
        """Record that the answer came."""
        time = now - self._first_at
        is_repeated = self._sent_at > self._first_at
        if is_repeated and now - self._sent_at > FASTEST * (self._smooth or 0.0):
            return
        if self._smooth is None:
            self._smooth, self._deviation = time, 0.5 * time
        else:
            self._deviation += DEVIATION_GAIN * (abs(self._smooth - time) - self._deviation)
            self._smooth += GAIN * (time - self._smooth)
        limit = self._smooth + DEVIATIONS * self._deviation
        self.limit = min(max(limit, self._least), self._longest)
