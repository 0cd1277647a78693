"""The other robots, as known from their beacons alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.beacon import (
    BEACON_DTYPE,
    BEACON_WORDS,
    FLAG_ACTIVE,
    FLAG_STUCK,
    HEARD_ENTRIES,
    HELD_POINTS,
    MODE_PAUSE,
    WANTED_POINTS,
    BeaconArray,
    Reception,
    reception_of,
)
from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_nav.core.config import TrafficConfig
from swarm_nav.perception import absence_kernels
from swarm_nav.perception import neighbor_table_kernels as kernels
from swarm_nav.perception.absence import Absence, Heard
from swarm_nav.perception.absence_kernels import Sightings

BODY_REACH = 0.12  # [m] beyond a neighbour's radius within which a beam does not help to localise
TRAVEL_PER_TICK = 0.03  # [m] that a neighbour may have moved since its beacon
TRAVEL_TICKS = 20  # for which it may have
FRESH_TICKS = 5  # age up to which a beacon tells that there is a robot, and nothing else
SPACING = 0.05  # [m] between the points of a tube
TUBE_LENGTH = 1.6  # [m] that the points of a beacon can be off its pose
UNHEARD_PATIENCE = 40  # ticks without an acknowledgement after which a robot stands
ACQUAINTING = 4  # ticks in which robots that come into range have heard each other
MAX_SPEED = 0.52  # [m/s] at which two robots can part
PARKED = 0.2  # [m] that the space of a robot that stands is long, at most
PASSED_EVERY = 8  # ticks between two checks for robots on the place of a silent one
MOST_BODY = 5.0  # [m] circumscribed radius up to which a beacon's footprint is believed
INITIAL_ROWS = 32
CLAIM_COLUMNS = kernels.Columns._fields[4:]  # those of beacons


class NeighborTable:
    """The newest beacon of every robot heard, with its age and whether the robot is gone.

    A robot that is not heard for `lost_ticks` is *gone* (dead or mute): it stays an obstacle at
    the space that it last held or requested, until it is heard again or that space was found
    empty. It has stopped once it has been silent for `dead_ticks`. If it was last heard near the
    range's edge it may have left: `Absence` decides once this robot is near there.

    Attributes:
        heads: (n,) beacons, ascending by id, without points, footprint and acknowledgements: a
            view that the next `refresh` overwrites.
        ids: (n,)
        ages: (n,) [ticks] since each was sent.
        gone: (n,)
        gate_columns: Poses, gate and blocked ticks and modes, of which the first n rows are in use.
        request_columns: Stations, station and gate ticks, likewise.
        priorities: (n,) as published.
        acks: (n,) tick of the newest of our beacons that each neighbour acknowledged; the present
            tick for neighbours that need not hear us.
        has_immovable: Whether any of the `immovable` ones is there.
        hears_split: Whether any robot that is heard says that the radio is split.
        mean_trip: [ticks] from own beacons to their acknowledgements now, 0 if none counts.
        deaf_neighbor: Id of a near robot that does not hear this one, 0 if all do.
        largest_body: [m] circumscribed radius of the largest robot heard so far, 0 without any.
        hearing_reach: [m] within which every robot that is heard has to hear this one: if one of
            them falls silent there, it is within the space that this robot knows.
    """

    def __init__(
        self, own_id: int, config: TrafficConfig, *, remembers_absent: bool = True
    ) -> None:
        """Start without neighbours.

        Args:
            remembers_absent: Whether robots last heard near the edge are remembered: for robots
                that acknowledge beacons, because they learn from each other which robots have left.
        """
        self._own_id = own_id
        self._remembers_absent = remembers_absent
        self._absence = Absence(own_id)
        self.configure(config)
        self._count = 0
        self._position = (0.0, 0.0)
        self._left_count = np.zeros(1, np.int64)
        self._has_silent = False  # whether any row is gone
        self._inbox: list[Heard] = []
        self._words: NDArray[np.uint32] = np.zeros((0, BEACON_WORDS), np.uint32)
        self._notes: NDArray[np.float64] = np.zeros((0, 2))
        self._links: NDArray[np.int64] = np.zeros((0, 4), np.int64)
        self._air = self._words  # of the last merge
        self._heard: NDArray[np.uint32] = np.zeros(HEARD_ENTRIES, np.uint32)
        self._heard_tick = -1  # of `_heard`
        self._is_pushed = False  # whether anybody says to be blocked by this robot
        self.has_immovable = self.hears_split = False
        self.mean_trip = 0.0
        self.deaf_neighbor = 0
        self.largest_body = 0.0
        self._allocate(INITIAL_ROWS)
        self._show(0)

    def configure(self, config: TrafficConfig) -> None:
        """Apply new parameters, effective from the next tick.

        Args:
            config: `traffic.` parameters.
        """
        parting = 2.0 * MAX_SPEED * CONTROL_PERIOD  # [m] per tick
        edge = config.radio_range - parting * config.lost_ticks
        self.hearing_reach = config.radio_range - parting * ACQUAINTING
        unheard = (UNHEARD_PATIENCE, self.hearing_reach, HEARD_ENTRIES)
        self._limits = (config.lost_ticks, edge, unheard)
        self._dead_ticks = config.dead_ticks
        self._hearing = (edge, config.radio_range)

    def receive(self, beacons: BeaconArray, x: float, y: float) -> None:
        """Receive beacons for the next `refresh`.

        Args:
            beacons: (n,) the radio's batch of a tick.
            x: [m] own position in map.
            y: [m] own position in map.
        """
        self.take(reception_of(beacons), x, y)

    def take(self, reception: Reception, x: float, y: float) -> None:
        """Receive beacons for the next `refresh`, without a copy.

        Args:
            reception: The radio's batch of a tick; it must not change until then.
            x: [m] own position in map.
            y: [m] own position in map.
        """
        self._position = (x, y)
        if len(reception.rows):
            self._inbox.append((reception, (x, y)))

    def refresh(self, tick: int) -> bool:
        """Store the received beacons, compute ages and forget robots that left.

        Returns:
            Whether one of them has a larger body than all before.
        """
        inbox, self._inbox = self._inbox, []
        if self._remembers_absent:
            self._ask_for_absent(inbox, tick)
        if self._has_silent and tick % PASSED_EVERY == 0:
            self.passed_by()
        most = self._count
        for reception, _ in inbox:
            most += len(reception.rows)
        if most > len(self._words):
            self._allocate(2 * most)
        rest = (self._columns, tick, self._limits, self._heard, (self._left, self._left_count))
        found = (self._count, 0, False, False, False, False, 0.0)
        for reception, (x, y) in inbox:
            heard = (reception.words, reception.rows)
            own = (x, y, self._own_id, self._limits[0])
            found = kernels.receive_batch(self._table, found[0], heard, self._air, own, *rest)
            self._air = reception.words
        if not inbox:
            words, _, notes, links = self._table
            found = kernels.refresh(
                words, notes, links, self._count, self._air, self._own_id, *rest
            )
        count, self.deaf_neighbor, self._is_pushed, self._has_silent = found[:4]
        self.has_immovable, self.hears_split, self.mean_trip = found[4:]
        self._heard_tick = tick
        is_larger = False
        if count != self._count or self._is_new:
            self._show(count)
            is_larger = self._record_bodies()
        if self._left_count[0]:
            if self._remembers_absent:
                words = self._left[: self._left_count[0]]
                self._absence.add(words, self._have_parted(words))
            self._left_count[0] = 0
        return is_larger

    def _record_bodies(self) -> bool:
        """Update the sizes of the robots that are heard; return whether the largest has grown."""
        corners = self.beacons["footprint"].astype(np.float64)
        reaches = np.hypot(corners[:, :, 0], corners[:, :, 1]).max(axis=1, initial=0.0)
        plausible = reaches[reaches <= MOST_BODY]
        largest = float(plausible.max(initial=0.0))
        is_larger = largest > self.largest_body
        if is_larger:
            self.largest_body = largest
        return is_larger

    def _ask_for_absent(self, inbox: list[Heard], tick: int) -> None:
        """Restore robots that seem not to have left, with the next batch, until they have."""
        if self._has_silent:  # before anything of their space is given up
            self._fetch()
            words = self._words[: self._count][self.gone]
            self._absence.add(words, np.zeros(len(words), np.bool_), is_obstacle=True)
        silent, left = self._absence.listen(inbox, self._position, self._hearing[0], tick)
        if len(silent):
            self._inbox.append((Reception(silent, np.arange(len(silent))), self._position))
        for robot in left:
            row = self.row(robot)
            if row is not None and self.gone[row]:
                self._words[row, [kernels.HELD_SIZE, kernels.WANTED_SIZE]] = 0

    def _have_parted(self, words: NDArray[np.uint32]) -> NDArray[np.bool_]:
        """Return a mask (n,) of robots whose own space leads out of range in their last beacon."""
        floats = words.view(np.float32)
        spans = [
            absence_kernels.nearest_and_farthest(words[k], floats[k], *self._position)
            for k in range(len(words))
        ]
        return np.array([far - near > PARKED and far > self._hearing[1] for near, far in spans])

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Robots that said that they cannot make way, and those that will not."""
        return ((self.heads["flags"] & FLAG_STUCK) > 0) | self.immovable

    @property
    def served(self) -> NDArray[np.bool_]:
        """Robots that stay at their station for now, since they are served there."""
        return np.asarray(self.heads["mode"] == MODE_PAUSE)

    @property
    def unyielding(self) -> NDArray[np.bool_]:
        """Robots that do not make way now: those that cannot, will not, or are served."""
        return self.stuck | self.served

    @property
    def immovable(self) -> NDArray[np.bool_]:
        """Robots that cannot be pushed: gone ones and those with an inactive navigator."""
        is_inactive: NDArray[np.bool_] = (self.heads["flags"] & FLAG_ACTIVE) == 0
        return self.gone | is_inactive

    def silenced(self, since: int) -> list[int]:
        """Return the ids of near robots that fell silent in the last ticks.

        Args:
            since: [ticks]
        """
        if not self._has_silent:
            return []
        is_new = self.gone & (self.ages <= self._limits[0] + since)
        found: list[int] = self.ids[is_new].tolist()
        return found

    def masks(
        self, x: float, y: float, reach: float, margin: float
    ) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
        """Return the discs in which a LiDAR hit belongs to a robot.

        Each is a place that its robot holds and that this one keeps out of anyhow.

        Args:
            x: [m] of the LiDAR in map.
            y: [m] of the LiDAR in map.
            reach: [m] of the LiDAR.
            margin: [m] by which the own radius exceeds the body's.

        Returns:
            Centres (k, 2) [m], radii (k,), and whether there is a robot there now (k,); the next
            call overwrites them.
        """
        discs, radii, is_fresh = self._masks
        count = kernels.masks(
            (self._words, self._floats), self._table[3], self._air, self.ages, self.gone,
            self._count, (x, y, reach + TUBE_LENGTH, margin), TRAVEL_PER_TICK / SPACING,
            FRESH_TICKS, self._masks,
        )  # fmt: skip
        return discs[:count], radii[:count], is_fresh[:count]

    def clear_empty_places(
        self,
        ranges: NDArray[np.float32],
        beam: tuple[float, float, float],
        pose: tuple[float, float, float],
        reach: float,
        body: tuple[NDArray[np.uint32], float],
    ) -> None:
        """Give up the places of silent robots that a scan finds empty, as the last one did.

        Args:
            ranges: (n,) [m].
            beam: (angle_min [rad], angle_increment [rad], range_min [m]).
            pose: (x [m], y [m], yaw [rad]) of the LiDAR in map.
            reach: [m] up to which rays tell of free space.
            body: Own footprint as words, and the radius [m] in which a LiDAR of its like is seen.
        """
        if self._has_silent:
            self._fetch()
            footprint, radius = body
            limits = (reach, radius, self._dead_ticks)
            kernels.clear_empty_places(*self._places(), (ranges, beam, pose), limits, footprint)

    def passed_by(self) -> None:
        """Give up the places of silent robots on which another robot is now."""
        self._fetch()
        kernels.passed(*self._places(), self._position, self._dead_ticks)

    def _places(self) -> tuple[NDArray[np.generic], ...]:
        return (self._words, self._floats, self._table[3], self.ages, self.gone)

    def bodies(self) -> tuple[FloatArray, FloatArray]:
        """Return centres (n, 2) [m] and radii (n,) of where beams may hit robots, generously.

        For the localisation, to which a beam too few does no harm.

        The next call overwrites them.
        """
        count = self._count
        robots, reach = self._bodies
        limits = (np.float32(BODY_REACH), TRAVEL_PER_TICK, TRAVEL_TICKS)
        kernels.bodies(self._floats, self.ages, limits, robots, reach)
        return robots[:count], reach[:count]

    @property
    def beacons(self) -> BeaconArray:
        """The beacons (n,), ascending by id; a view that the next `refresh` overwrites."""
        self._fetch()
        return self.heads

    def _fetch(self) -> None:
        kernels.fetch(self._words, self._links, self._count, self._air)

    def claims(self) -> tuple[NDArray[np.generic], ...]:
        """Return the fields of `tube_kernels.Claims`, as a plain tuple for calls in every tick."""
        return (self.ids, self.acks, self.gone, self.priorities, *self._rows, self._air)

    def columns(self) -> tuple[NDArray[np.generic], ...]:
        """Return the fields of `neighbor_table_kernels.Columns`, as a plain tuple.

        The first four have a row per robot, the others are views of the whole table: a view of
        one row would be contiguous, and numba would compile the kernels a second time for it.
        """
        self._fetch()
        return (self.ids, self.acks, self.gone, self.priorities, *self._claims)

    def heard(self, tick: int) -> NDArray[np.uint32]:
        """Return the acknowledgements for a beacon; the next call overwrites them."""
        if tick != self._heard_tick:
            self._heard_tick = tick
            kernels.acknowledge(self._words, self._notes, self._count, tick, self._heard)
        return self._heard

    def sighted(self, tick: int) -> NDArray[np.uint32]:
        """Return where robots were last, for a beacon: its words from `sighted_id` on.

        Args:
            tick: Tick of the beacon. The next call overwrites what is returned.
        """
        return self._absence.tell(tick)

    @property
    def sightings(self) -> Sightings:
        """Last place of each robot, as far as this one knows it from anybody."""
        return self._absence.sightings

    def radius(self, row: int) -> float:
        """Return the safety radius [m] of a robot."""
        return float(self._floats[row, kernels.RADIUS])

    def row(self, robot_id: int) -> int | None:
        """Return the row of a robot, None if it is not known."""
        row = kernels.row_of(self.ids, robot_id)
        return row if row >= 0 else None

    def highest_pusher(self, priority: int, patience: int) -> int | None:
        """Return the row of the highest robot that this one has blocked for a while.

        Args:
            priority: Priority that it must exceed; it must not make way for this robot either.
            patience: Ticks for which it has been blocked, at least.

        Returns:
            The row; None if there is no such robot.
        """
        if not self._is_pushed:
            return None
        own = (self._own_id, priority)
        row = kernels.highest_pusher(self._words, self.gone, self.priorities, own, patience)
        return row if row >= 0 else None

    def queue(self, stations: NDArray[np.float64], tick: int, same: float) -> tuple[int, int, int]:
        """Return the requests of other robots for one of some stations.

        Args:
            stations: (k, 2) [m] in map.
            same: [m] within which two stations are the same.

        Returns:
            The number of those that asked before this robot, the id of the first of them, and the
            highest priority of all; 0 for none.
        """
        count, first, highest = kernels.queue(
            self._words, self._floats, self.gone, self.priorities, stations, tick, self._own_id,
            same,
        )  # fmt: skip
        return int(count), int(first), int(highest)

    def tubes(self, row: int) -> NDArray[np.float32]:
        """Return the held points of one robot, and its requested ones if it is gone.

        Returns:
            (n, 2) [m] in map.
        """
        beacon = self.beacons[row]
        held: NDArray[np.float32] = beacon["held"][: beacon["held_size"]]
        if not self.gone[row]:
            return held
        return np.vstack((held, beacon["wanted"][: beacon["wanted_size"]]))

    def _allocate(self, rows: int) -> None:
        """Make the table `rows` long."""
        words = np.zeros((rows, BEACON_WORDS), np.uint32)
        words[: self._count] = self._words[: self._count]
        notes = np.zeros((rows, 2))
        notes[: self._count] = self._notes[: self._count]
        links = np.zeros((rows, 4), np.int64)
        links[: self._count] = self._links[: self._count]
        self._words, self._notes, self._links = words, notes, links
        self._floats = words.view(np.float32)
        self._table = (words, self._floats, notes, links)
        self._rows = (words, links)
        self._is_new = True  # not shown yet
        self._records: BeaconArray = words.view(BEACON_DTYPE)[:, 0]
        self._columns = (
            np.zeros(rows, np.uint32),
            np.zeros(rows, np.int64),
            np.zeros(rows, np.bool_),
            np.zeros(rows, np.int64),
            np.zeros(rows, np.int64),
        )
        self._bodies = np.zeros((rows, 2)), np.zeros(rows)
        self._left = np.zeros((rows, BEACON_WORDS), np.uint32)
        places = rows * (HELD_POINTS + WANTED_POINTS)
        self._masks = np.empty((places, 2)), np.empty(places), np.empty(places, np.bool_)
        # views of the whole table, see `columns`
        of_gate = ("pose", "gate_tick", "blocked_ticks", "mode")
        of_request = ("station", "station_tick", "gate_tick")
        self.gate_columns = tuple(self._records[name] for name in of_gate)
        self.request_columns = tuple(self._records[name] for name in of_request)
        self._claims = tuple(self._records[name] for name in CLAIM_COLUMNS)

    def _show(self, count: int) -> None:
        """Point the public arrays at the rows in use."""
        self._count, self._is_new = count, False
        self.heads: BeaconArray = self._records[:count]
        ids, ages, gone, priorities, acks = self._columns
        self.ids: NDArray[np.uint32] = ids[:count]
        self.ages: NDArray[np.int64] = ages[:count]
        self.gone: NDArray[np.bool_] = gone[:count]
        self.priorities: NDArray[np.int64] = priorities[:count]
        self.acks: NDArray[np.int64] = acks[:count]
