"""Keys of `swarm-teleop`: what the pressed one means, and that it must be kept pressed."""

from __future__ import annotations

from swarm_common.model.records import Twist

HOLD = 0.6  # [s] that a key counts: longer than a keyboard waits before it repeats
FACTOR = 1.25  # of a step of the speed
LEAST, MOST = 0.1, 1.0  # share of the robot's full speed
ARROWS = {"\x1b[A": "w", "\x1b[B": "s", "\x1b[C": "d", "\x1b[D": "a"}
WAYS = {"w": (1.0, 0.0), "s": (-1.0, 0.0), "a": (0.0, 1.0), "d": (0.0, -1.0)}
ENDS = ("q", "\x04")
HELP = """\
  w or up      ahead          + / -   faster / slower
  s or down    back           space   stop
  a or left    turn left      q       end (or Ctrl-C); the robot goes on with its mission
  d or right   turn right
Keep a key pressed: half a second without one, the robot stops."""


class Keys:
    """Command of the operator, by the keys so far.

    Attributes:
        share: Share of the full speed, 0 to 1.
        is_over: Whether the operator has had enough.
    """

    def __init__(self, full: Twist) -> None:
        self.share = 0.5
        self.is_over = False
        self._full = full
        self._way = (0.0, 0.0)
        self._until = 0.0

    def press(self, text: str, now: float) -> None:
        """Receive the text that was typed at a time [s]; the last key counts."""
        for sequence, key in ARROWS.items():
            text = text.replace(sequence, key)
        for key in text:
            if key in WAYS:
                self._way, self._until = WAYS[key], now + HOLD
            elif key in "+-":
                factor = FACTOR if key == "+" else 1.0 / FACTOR
                self.share = min(MOST, max(LEAST, self.share * factor))
            elif key in ENDS:
                self.is_over = True
            else:
                self._until = now

    def end(self) -> None:
        """The operator has had enough."""
        self.is_over = True

    def wish(self, now: float) -> Twist:
        """Return the velocity that is wanted at a time [s]: none without a key pressed."""
        if now >= self._until or self.is_over:
            return Twist()
        ahead, turn = self._way
        return Twist(self.share * self._full.vx * ahead, 0.0, self.share * self._full.wz * turn)
