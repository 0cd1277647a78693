"""Scans and beacons that a robot receives, and whether there are enough of them to drive on."""

from __future__ import annotations

from swarm_common.model.beacon import Reception
from swarm_common.model.records import Scan
from swarm_nav.traffic.robot_state import RobotState

EMPTY = "stands: its battery is empty"
SPLIT = "stands: several robots fell silent at once"
SEVERAL = 2  # robots that fall silent
AT_ONCE = 10  # ticks within which they do
SPLIT_PATIENCE = 1200  # ticks after which those that are not heard again count as dead


class Senses:
    """Receives scans and the radio's batches; without data it stops, after a silence it listens.

    Attributes:
        missing: Missing input that keeps the robot from driving (no scans, no radio), empty if
            nothing.
        is_deaf: Whether nothing was heard for so long that all must be listened to anew.
        is_split: Whether several near robots fell silent at once, and none is heard again.
    """

    def __init__(self, robot: RobotState) -> None:
        """Start before the first scan and the first batch of the radio."""
        self._s = robot
        self.missing = ""
        self.is_deaf = self.is_split = False
        self._is_hearing = False
        self._deaf_ticks = 0
        self._scan_tick = -1
        self._silenced: list[int] = []  # ids of robots that fell silent at once
        self._silent_since = 0  # tick

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan; it marks obstacles only once the robots around are known by radio."""
        self._scan_tick = scan.tick
        s = self._s
        if scan.tick - s.listening_since > s.config.traffic.listen_ticks // 2:
            s.obstacles.update(scan, s.pose, s.terrain, s.neighbors, s.radius - s.body_radius)

    def on_reception(self, reception: Reception) -> None:
        """Receive the radio's batch of this tick where it is, without a copy.

        Args:
            reception: Beacons as words, and the rows that are heard.
        """
        self._is_hearing = True
        self._s.neighbors.take(reception, self._s.pose.x, self._s.pose.y)

    def listen_anew(self) -> None:
        """Hold only what is held until the radio has been heard for a while without a gap."""
        self._s.listening_since = self._s.tick

    def update(self, is_lost: bool = False, is_empty: bool = False) -> bool:
        """Close the observations of this tick; return whether there are enough to drive on.

        Args:
            is_lost: Whether the robot does not know well enough where it is.
            is_empty: Whether its battery is empty.
        """
        self._record_deafness()
        if self._scan_tick < 0:
            self._record_split()
        is_hearing, self._is_hearing = self._is_hearing, False
        self.missing = EMPTY if is_empty else self._missing(is_lost, is_hearing)
        return not self.missing

    def _missing(self, is_lost: bool, is_hearing: bool) -> str:
        """Return in words what keeps the robot from driving; empty if nothing does."""
        s = self._s
        timeout = s.config.costmap.scan_timeout
        if is_lost:
            return "stands: lost"
        if not is_hearing:
            return "stands: its radio delivers nothing"
        unheard_by = s.neighbors.deaf_neighbor
        if unheard_by:
            return f"stands: {s.names.name_of(unheard_by)} does not hear it"
        if self.is_split or (self._scan_tick < 0 and s.neighbors.hears_split):
            return SPLIT
        if timeout > 0.0 and s.tick - max(self._scan_tick, s.listening_since) > s.ticks(timeout):
            return f"stands: no scan for more than {timeout:.1f} s"
        return ""

    def _record_split(self) -> None:
        """Find out whether near robots fell silent at once; it counts for a robot without scans.

        Robots seldom die at once. A radio that is split leaves both sides driving, and who sees
        nothing either would take the others for dead where they last were.
        """
        neighbors, tick = self._s.neighbors, self._s.tick
        found = neighbors.silenced(AT_ONCE)
        if len(found) >= SEVERAL:
            self._silenced, self._silent_since = found, tick
        if self._silenced:
            rows = [neighbors.row(robot) for robot in self._silenced]
            is_back = any(row is not None and not neighbors.gone[row] for row in rows)
            if is_back or tick - self._silent_since > SPLIT_PATIENCE:
                self._silenced = []
        self.is_split = bool(self._silenced)

    def _record_deafness(self) -> None:
        """Listen again after a silence in which robots may have come near unheard."""
        if not self._is_hearing:
            self._deaf_ticks += 1
            self.is_deaf = self._deaf_ticks > self._s.config.traffic.lost_ticks
            return
        if self.is_deaf:
            self.listen_anew()
        self._deaf_ticks = 0
        self.is_deaf = False
