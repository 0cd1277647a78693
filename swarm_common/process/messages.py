"""Messages between swarm-up and the processes that it starts: every kind, with its fields.

A process reports `Event`s to swarm-up and takes commands from it, one JSON object per line; the
field `event` or `cmd` names the kind. Each process takes the kinds of its own union of commands.
A line of any other kind, or with other fields, is an error that quotes it (`decode`).
"""

from __future__ import annotations

from typing import Any, TypeVar

import msgspec

from swarm_common.model.breaches import Collision, MissedGoal
from swarm_common.model.errors import SwarmError

Kind = TypeVar("Kind")
LONGEST_QUOTE = 200  # characters of a line that nobody understands


class UnknownMessageError(SwarmError):
    """A line is not a message of a known kind."""


def encode(message: EventBase | CommandBase) -> bytes:
    """Return a message as a line, with its end."""
    return msgspec.json.encode(message, enc_hook=_plain) + b"\n"


def decode(line: bytes, decoder: msgspec.json.Decoder[Kind]) -> Kind:
    """Return the message in a line.

    Args:
        decoder: Decoder of the expected kinds, like `FORK_SERVER`.

    Raises:
        UnknownMessageError: If its kind is not one of the decoder's, or its fields are others.
    """
    try:
        return decoder.decode(line)
    except msgspec.DecodeError as error:
        quote = line[:LONGEST_QUOTE].decode(errors="replace")
        raise UnknownMessageError(f"unknown message {quote}: {error}") from None


def _plain(value: Any) -> Any:
    return value.item()


# Events: what a process reports to swarm-up


class EventBase(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True, tag_field="event"
):
    """Fields are in SI units and in the map frame."""


class Ready(EventBase, frozen=True, tag="ready"):
    """The process does its work from now on."""


class Refused(EventBase, frozen=True, tag="error"):
    """The process refuses its input and ends."""

    message: str


class Note(EventBase, frozen=True, tag="note"):
    """Something that the user should read."""

    message: str


class Compiling(EventBase, frozen=True, tag="compiling"):
    """Kernels are being compiled, as on a first start: how many are ready, of how many."""

    ready: int
    known: int


class InputsRejected(EventBase, frozen=True, tag="rejected"):
    """Inputs that were rejected since the last such event: how many, and the first of each kind."""

    counts: dict[str, int]
    notices: dict[str, str]


class ForeignPublisher(EventBase, frozen=True, tag="foreign"):
    """A node publishes where only a part of the swarm may."""

    topic: str
    node: str


class ConditionsChecked(EventBase, frozen=True, tag="conditions"):
    """Room on the map, reported by the navigators; `findings` are conditions that do not hold."""

    text: str
    guaranteed: bool
    places: int
    robots: int
    findings: list[str]


class MeetingPorts(EventBase, frozen=True, tag="meeting"):
    """Ports of world or mission that each robot of a large swarm announces itself to."""

    party: str
    ports: dict[str, list[int]]


class CollisionCounts(msgspec.Struct, frozen=True):
    """Contact episodes so far."""

    robot_robot: int = 0
    robot_world: int = 0


class WorldProgress(EventBase, frozen=True, tag="progress"):
    """State of the world, twice a second; a robots' host reports what its world's host says."""

    sim_time: float
    real_time_factor: float
    collisions: CollisionCounts
    min_clearance: float | None = None
    late_ticks: int = 0
    answering: int = 0
    is_paused: bool = False


class WorldBuilt(EventBase, frozen=True, tag="spawn"):
    """The world is built; `poses` (x, y, yaw) are those of all robots, `map_sha256` is a digest."""

    poses: list[tuple[float, float, float]]
    map_sha256: str = ""
    unseen: list[str] = []  # whose LiDAR sees too little of broken robots, a sentence each


class RobotSpawned(EventBase, frozen=True, tag="spawned"):
    """A robot came while the run goes on."""

    robot: str
    number: int
    model: str
    pose: tuple[float, float, float]
    sim_time: float


class RobotRemoved(EventBase, frozen=True, tag="removed"):
    """A robot was taken out of the world."""

    robot: str
    sim_time: float


class RobotLate(EventBase, frozen=True, tag="late"):
    """A robot did not answer in time; `is_alone` if at least half of all did."""

    robot: str
    seconds: float
    is_alone: bool


class CollisionBegan(EventBase, frozen=True, tag="collision"):
    """A contact episode began."""

    collision: Collision


class VerdictReached(EventBase, frozen=True, tag="verdict"):
    """The verdict at the end of a run, see `swarm_sim.world.verdict`."""

    verdict: dict[str, Any]


class TimeOver(EventBase, frozen=True, tag="over"):
    """The duration that the world was to run for is over."""


class NavigatorForked(EventBase, frozen=True, tag="forked"):
    """The fork server has started the navigator of a robot."""

    robot: str
    pid: int


class NavigatorActive(EventBase, frozen=True, tag="active"):
    """A navigator is active."""

    robot: str
    pid: int = 0


class NavigatorDied(EventBase, frozen=True, tag="died"):
    """A navigator died; `host` labels its host if that is another one."""

    robot: str
    returncode: int
    host: str = ""


class Alive(EventBase, frozen=True, tag="alive"):
    """A sign of life of a process that has nothing else to report."""


class CentreReported(EventBase, frozen=True, tag="centre"):
    """Cost of the centre since its start."""

    figures: dict[str, float]


class MissionLoaded(EventBase, frozen=True, tag="mission"):
    """The mission has this many goals in all."""

    goals: int


class GoalSent(EventBase, frozen=True, tag="sent"):
    """A goal was sent for the first time."""

    robot: str
    goal: str


class GoalReached(EventBase, frozen=True, tag="reached"):
    """A robot reached a goal, `duration` after it was free to set off for it."""

    robot: str
    goal: str
    sim_time: float
    duration: float


class GoalMissed(EventBase, frozen=True, tag="missed"):
    """A goal was given up."""

    missed: MissedGoal


class GoalWithdrawn(EventBase, frozen=True, tag="withdrawn"):
    """A goal no longer counts, as its robot was taken out."""

    robot: str


class GoalsRestored(EventBase, frozen=True, tag="found"):
    """A robot that had lost its goals is heard again; `goals` of them count again."""

    robot: str
    goals: int
    goal: str


class MissionDone(EventBase, frozen=True, tag="done"):
    """The mission is over."""


class StatusReported(EventBase, frozen=True, tag="status"):
    """Totals that swarm-up keeps of a robot's status message; `goal_map` is its goal."""

    robot: str
    state: str
    detail: str
    goal_map: tuple[float, float] | None
    sim_time: float
    hold_time: float
    wait_time: float
    goals_reached: int
    goals_failed: int
    pushes: int
    retreats: int
    deadlocks_resolved: int
    replans: int
    number_of_recoveries: int
    battery: float | None = None  # charge by capacity; None without a battery


class OrdersReported(EventBase, frozen=True, tag="orders"):
    """Events of orders, see `swarm_mission.orders.order_book.OrderEvent`."""

    events: list[dict[str, Any]]


class FloorReported(EventBase, frozen=True, tag="floor"):
    """Use of floor and time by a courier's robots so far, see `swarm_mission.orders.floor_use`."""

    courier: int  # number of its process
    figures: dict[str, Any]


class StationDone(EventBase, frozen=True, tag="station_done"):
    """All orders of a station have come and are done."""

    station: str


class SwarmHeard(EventBase, frozen=True, tag="swarm_heard"):
    """The mission process is connected to the status of all robots that it can find."""


class RecordingBegun(EventBase, frozen=True, tag="recording"):
    """The recorder records: it has heard the world."""

    path: str
    topics: int


class RecordingEnded(EventBase, frozen=True, tag="recorded"):
    """The recorder has closed its file."""

    path: str
    messages: int
    lost: dict[str, int] = {}  # how many were sent and did not reach it, by topic
    missing: list[str] = []  # topics that stay for latecomers, and did not reach it


class FleetJudged(EventBase, frozen=True, tag="judged"):
    """The verdict on a fleet control, which `file` has rule by rule."""

    text: str
    file: str
    is_failed: bool = False  # whether it ends the run with exit code 1


class ViewerOpened(EventBase, frozen=True, tag="viewer"):
    """The browser view is served."""

    url: str


# Events of the world's host about the robots' hosts


class HostEvent(EventBase, frozen=True):
    """About a robots' host: its id, its name for people, and its robots."""

    id: str
    host: str
    robots: tuple[str, ...]


class HostJoined(HostEvent, frozen=True, tag="enlisted"):
    """A host has taken on its robots."""


class HostRejected(HostEvent, frozen=True, tag="turned_away"):
    """A host may not take part."""

    reason: str


class HostSilent(HostEvent, frozen=True, tag="silent"):
    """Nothing has been heard of a host for `seconds`."""

    seconds: float


class HostHeard(HostEvent, frozen=True, tag="heard"):
    """A host is heard again after `seconds`."""

    seconds: float


class HostDeaf(HostEvent, frozen=True, tag="deaf"):
    """A host has not heard this one for `seconds`."""

    seconds: float


class HostLost(HostEvent, frozen=True, tag="lost"):
    """A host was silent for too long and is given up."""

    seconds: float


class HostLeft(HostEvent, frozen=True, tag="left"):
    """A host was stopped by its user."""


class HostUnanswered(EventBase, frozen=True, tag="unhearing"):
    """A host at an address asks and does not hear the answers."""

    address: str


class HostsSummary(EventBase, frozen=True, tag="hosts"):
    """All hosts, for the report."""

    hosts: list[dict[str, Any]]


# Events of a robots' host about the world's host


class WorldFound(EventBase, frozen=True, tag="welcome"):
    """The world's host has taken this host on."""


class WorldUnansweredYet(EventBase, frozen=True, tag="unanswered_yet"):
    """No world's host has answered for `seconds`; the search goes on."""

    seconds: float


class WorldUnanswered(EventBase, frozen=True, tag="unanswered"):
    """No world's host has answered for `seconds`; the search is given up."""

    seconds: float


class WorldHasOtherSecret(EventBase, frozen=True, tag="other_secret"):
    """The only world's host that is heard has another secret."""


class WorldSilent(EventBase, frozen=True, tag="world_silent"):
    """Nothing is heard of the world's host."""


class WorldHeard(EventBase, frozen=True, tag="world_heard"):
    """The world's host is heard again after `seconds`."""

    seconds: float


class WorldUnhearing(EventBase, frozen=True, tag="unheard"):
    """The world's host is heard, but does not hear this host."""


class WorldLost(EventBase, frozen=True, tag="world_lost"):
    """The world's host is given up."""

    message: str


class WorldOver(EventBase, frozen=True, tag="world_over"):
    """The run has ended on the world's host."""

    reason: str


class RobotTakenOut(EventBase, frozen=True, tag="taken_out"):
    """The world's host has taken a robot of this host out of the world."""

    robot: str


class NetworkFault(EventBase, frozen=True, tag="network_fault"):
    """Something is wrong with the network between the hosts."""

    message: str


class NetworkFigures(EventBase, frozen=True, tag="network"):
    """Findings of the network's probes, for the report."""

    figures: dict[str, float]


# Who reports what

ProcessEvent = (
    Ready
    | Alive
    | Refused
    | Note
    | Compiling
    | InputsRejected
    | ForeignPublisher
    | ConditionsChecked
    | NavigatorForked
    | VerdictReached
    | WorldProgress
    | RecordingBegun
    | CentreReported
)
WorldEvent = (
    WorldBuilt | MeetingPorts | RobotSpawned | RobotRemoved | RobotLate | CollisionBegan | TimeOver
)
NavigatorEvent = NavigatorActive | NavigatorDied
MissionEvent = (
    MissionLoaded
    | SwarmHeard
    | GoalSent
    | GoalReached
    | GoalMissed
    | GoalWithdrawn
    | GoalsRestored
    | MissionDone
    | StatusReported
    | OrdersReported
    | FloorReported
    | StationDone
)
OnlookerEvent = RecordingEnded | FleetJudged | ViewerOpened
ServerEvent = (
    HostJoined
    | HostRejected
    | HostSilent
    | HostHeard
    | HostDeaf
    | HostLost
    | HostLeft
    | HostUnanswered
    | HostsSummary
)
ClientEvent = (
    WorldFound
    | WorldUnansweredYet
    | WorldUnanswered
    | WorldHasOtherSecret
    | WorldSilent
    | WorldHeard
    | WorldUnhearing
    | WorldLost
    | WorldOver
    | RobotTakenOut
    | NetworkFault
    | NetworkFigures
)
OwnEvent = (  # of processes that only some kinds of run have
    WorldEvent | NavigatorEvent | MissionEvent | OnlookerEvent | ServerEvent | ClientEvent
)
Event = ProcessEvent | OwnEvent


# Commands: what swarm-up tells a process


class CommandBase(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True, tag_field="cmd"
):
    """Fields are in SI units."""


class RobotCommand(CommandBase, frozen=True):
    """About one robot."""

    robot: str


class Go(CommandBase, frozen=True, tag="go"):
    """Read the configuration and start all navigators."""


class BeginTime(CommandBase, frozen=True, tag="begin"):
    """Time may begin: whoever is to see all of it is there."""


class EndTime(CommandBase, frozen=True, tag="end_time"):
    """No tick follows any more; whoever records takes what has been sent."""


class StartNavigator(RobotCommand, frozen=True, tag="start"):
    """Start the navigator of a robot with a parameter file."""

    params: str


class EndNavigator(RobotCommand, frozen=True, tag="end"):
    """End the navigator of a robot that was taken out."""


class KillNavigator(RobotCommand, frozen=True, tag="kill"):
    """Kill the navigator of a robot, which hangs; that it died is reported."""


class RobotDead(RobotCommand, frozen=True, tag="dead"):
    """The navigator of a robot is gone for good."""


class RobotSilent(RobotCommand, frozen=True, tag="silent"):
    """The navigator or the host of a robot has been silent for `seconds`; it may come back."""

    seconds: float = 0.0


class RobotHeard(RobotCommand, frozen=True, tag="heard"):
    """A robot that was silent is heard again."""


class RobotGone(RobotCommand, frozen=True, tag="removed"):
    """A robot was taken out of the world."""


class WatchRobot(RobotCommand, frozen=True, tag="watch"):
    """Follow a robot that came while the run goes on."""


class ServeHost(CommandBase, frozen=True, tag="host"):
    """A robots' host serves these robots; its messages are sealed with name, run and secret."""

    robots: tuple[str, ...]
    host: str
    run: str
    secret: str


class Figures(msgspec.Struct, frozen=True):
    """Figures of the world that the robots' hosts show."""

    sim_time: float
    real_time_factor: float
    collisions: CollisionCounts


class ShowFigures(CommandBase, frozen=True, tag="figures"):
    """Send the state of the world to the robots' hosts."""

    figures: Figures


class RunOver(CommandBase, frozen=True, tag="over"):
    """The run ends, and why."""

    reason: str


class ReportActive(RobotCommand, frozen=True, tag="active"):
    """Report to the world's host that a navigator is active."""


class ReportDeath(RobotCommand, frozen=True, tag="died"):
    """Report to the world's host that a navigator died for good."""

    returncode: int


class ReportUsage(CommandBase, frozen=True, tag="usage"):
    """Report to the world's host what the navigators have used: [s] of CPU time, [MB]."""

    cpu: float
    rss_mb: float


class RestartNavigator(RobotCommand, frozen=True, tag="restart"):
    """The user of another terminal wants a navigator started again."""


class KernelsCompiled(CommandBase, frozen=True, tag="compiled"):
    """Progress of a first start, for viewers: how many kernels are ready, of how many."""

    ready: int
    known: int


ForkServerCommand = Go | StartNavigator | EndNavigator | KillNavigator
WorldCommand = BeginTime | EndTime | ServeHost | RobotDead | RobotSilent | RobotHeard
MissionCommand = WatchRobot | RobotSilent | RobotHeard | RobotDead | RobotGone
ServerCommand = ShowFigures | RobotGone | RunOver
ClientCommand = ReportActive | ReportDeath | ReportUsage

EVENTS: msgspec.json.Decoder[Event] = msgspec.json.Decoder(Event)
FORK_SERVER: msgspec.json.Decoder[ForkServerCommand] = msgspec.json.Decoder(ForkServerCommand)
WORLD: msgspec.json.Decoder[WorldCommand] = msgspec.json.Decoder(WorldCommand)
MISSION: msgspec.json.Decoder[MissionCommand] = msgspec.json.Decoder(MissionCommand)
SERVER: msgspec.json.Decoder[ServerCommand] = msgspec.json.Decoder(ServerCommand)
CLIENT: msgspec.json.Decoder[ClientCommand] = msgspec.json.Decoder(ClientCommand)
VIEWER: msgspec.json.Decoder[KernelsCompiled] = msgspec.json.Decoder(KernelsCompiled)
USER: msgspec.json.Decoder[RestartNavigator] = msgspec.json.Decoder(RestartNavigator)
