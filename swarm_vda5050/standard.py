"""The standard in tables: the fields of every message, with kinds, bounds and names by version.

One row describes a field in all versions. `dialect` reads and writes messages by these rows, so a
field, a name, a word or a bound has no other home. Names inside the package are those of 2.1, and
of the version that brought a field where 2.1 lacks it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

VERSIONS = {"2.0": "2.0.0", "2.1": "2.1.0", "3.0": "3.0.0"}  # as asked for and as in headers
INTERFACES = {"2.0": "uagv", "2.1": "uagv", "3.0": "vda5050"}  # first level of topics
INCOMING = {  # versions by topic of the fleet control
    "order": "2.0 2.1 3.0",
    "instantActions": "2.0 2.1 3.0",
    "zoneSet": "3.0",
    "responses": "3.0",
}
PI = 3.141592654  # the largest angle that the schemas let pass
LARGEST = 2**32 - 1  # of whole numbers
LONGEST_ID = 256  # characters, as the factsheet says


class Text(NamedTuple):
    """A text of so many characters; `is_time` for an ISO 8601 timestamp."""

    least: int = 0
    most: float = math.inf
    is_time: bool = False


class Flag(NamedTuple):
    """True or false."""


class Number(NamedTuple):
    """A number within bounds."""

    low: float = -math.inf
    high: float = math.inf
    is_whole: bool = False


class Words(NamedTuple):
    """One word of several; inside by wire."""

    inside: Mapping[str, str]


class Record(NamedTuple):
    """An object with the fields of a table."""

    table: str


class Each(NamedTuple):
    """An array."""

    kind: Text | Number | Record | Words
    least: int = 0  # entries


class Anything(NamedTuple):
    """A value of any type but null."""


Kind = Text | Flag | Number | Words | Record | Each | Anything


class WireField(NamedTuple):
    """A field in one version."""

    inside: str
    kind: Kind
    is_required: bool


TEXT, ID, TIME = Text(), Text(least=1, most=LONGEST_ID), Text(is_time=True)
FLAG, NUMBER, ANY = Flag(), Number(), Anything()
COUNT, ANGLE, POSITIVE = Number(0, LARGEST, is_whole=True), Number(-PI, PI), Number(low=0.0)
SHARE, PERCENT = Number(0.0, 1.0), Number(0.0, 100.0)


def words(text: str) -> Words:
    """Return a kind of `text`, whose words may be like INSIDE=WIRE where the two differ."""
    pairs = (word.partition("=") for word in text.split())
    return Words({wire or inside: inside for inside, _, wire in pairs})


_Rows = tuple[tuple[str, Kind, str], ...]
# name inside, kind, and by version: - absent, o optional, ! required, with the name if another;
# `o=a|b` is read under either name and written under the first
_HEADER: _Rows = (
    ("headerId", COUNT, "! ! !"),
    ("timestamp", TIME, "! ! !"),
    ("version", TEXT, "! ! !"),
    ("manufacturer", TEXT, "! ! !"),
    ("serialNumber", TEXT, "! ! !"),
)
_ACTION: _Rows = (
    ("actionType", TEXT, "! ! !"),
    ("actionDescription", TEXT, "o o o=actionDescriptor"),
    ("actionParameters", Each(Record("actionParameter")), "o o o"),
)
_ON_WAY = words("NONE SOFT HARD"), words("NONE SINGLE SOFT HARD")
_GRANTS = words("REQUESTED GRANTED REVOKED EXPIRED")
_ENABLED = words("ENABLED DISABLED")
_ROWS: dict[str, _Rows] = {
    "order": (
        *_HEADER,
        ("orderId", ID, "! ! !"),
        ("orderUpdateId", COUNT, "! ! !"),
        ("zoneSetId", ID, "o o -"),
        ("orderDescription", TEXT, "- - o"),
        ("nodes", Each(Record("node")), "! ! !"),
        ("edges", Each(Record("edge")), "! ! !"),
    ),
    "node": (
        ("nodeId", ID, "! ! !"),
        ("sequenceId", COUNT, "! ! !"),
        ("nodeDescription", TEXT, "o o o=nodeDescriptor"),
        ("released", FLAG, "! ! !"),
        ("nodePosition", Record("nodePosition"), "o o o"),
        ("actions", Each(Record("action")), "! ! !"),
    ),
    "nodePosition": (
        ("x", NUMBER, "! ! !"),
        ("y", NUMBER, "! ! !"),
        ("theta", ANGLE, "o o o"),
        ("allowedDeviationXY", POSITIVE, "o=allowedDeviationXY|allowedDeviationXy o -"),
        ("allowedDeviationXY", Record("ellipse"), "- - o"),
        ("allowedDeviationTheta", Number(0.0, PI), "o o o"),
        ("mapId", ID, "! ! !"),
        ("mapDescription", TEXT, "o o -"),
    ),
    "ellipse": (
        ("a", POSITIVE, "- - !"),
        ("b", POSITIVE, "- - !"),
        ("theta", Number(-PI / 2, PI / 2), "- - !"),
    ),
    "edge": (
        ("edgeId", ID, "! ! !"),
        ("sequenceId", COUNT, "! ! !"),
        ("edgeDescription", TEXT, "o o o=edgeDescriptor"),
        ("released", FLAG, "! ! !"),
        ("startNodeId", ID, "! ! -"),
        ("endNodeId", ID, "! ! -"),
        ("maxSpeed", NUMBER, "o o o=maximumSpeed"),
        ("maxHeight", NUMBER, "o o o=maximumMobileRobotHeight"),
        ("minHeight", NUMBER, "o o o=minimumLoadHandlingDeviceHeight"),
        ("orientation", ANGLE, "o o o"),
        ("orientationType", words("GLOBAL TANGENTIAL"), "o o o"),
        ("direction", TEXT, "o o o"),
        ("rotationAllowed", FLAG, "o o -"),
        ("reachOrientationBeforeEntering", FLAG, "- - o"),
        ("maxRotationSpeed", NUMBER, "o o o"),
        ("length", NUMBER, "o=length|distance o o"),
        ("trajectory", Record("trajectory"), "o o o"),
        ("corridor", Record("corridor"), "- o o"),
        ("actions", Each(Record("action")), "! ! !"),
    ),
    "trajectory": (
        ("degree", Number(1, LARGEST, is_whole=True), "! ! o"),
        ("knotVector", Each(SHARE), "! ! o"),
        ("controlPoints", Each(Record("controlPoint")), "! ! !"),
    ),
    "controlPoint": (
        ("x", NUMBER, "! ! !"),
        ("y", NUMBER, "! ! !"),
        ("weight", POSITIVE, "o o o"),
        ("orientation", ANGLE, "o - -"),
    ),
    "corridor": (
        ("leftWidth", POSITIVE, "- ! !"),
        ("rightWidth", POSITIVE, "- ! !"),
        ("corridorRefPoint", words("KINEMATICCENTER CONTOUR"), "- o -"),
        (
            "corridorRefPoint",
            words("KINEMATICCENTER=KINEMATIC_CENTER CONTOUR"),
            "- - o=corridorReferencePoint",
        ),
        ("releaseRequired", FLAG, "- - o"),
        ("releaseLossBehavior", words("STOP RETURN"), "- - o"),
    ),
    "action": (
        *_ACTION,
        ("actionId", ID, "! ! !"),
        ("blockingType", _ON_WAY[0], "! ! -"),
        ("blockingType", _ON_WAY[1], "- - !"),
        ("retriable", FLAG, "- - o"),
    ),
    "zoneAction": (
        *_ACTION,
        ("blockingType", _ON_WAY[1], "- - !"),
        ("retriable", FLAG, "- - o"),
    ),
    "instantAction": (
        *_ACTION,
        ("actionId", ID, "! ! !"),
        ("blockingType", _ON_WAY[0], "! ! -"),
        ("blockingType", words("NONE"), "- - !"),
    ),
    "actionParameter": (("key", TEXT, "! ! !"), ("value", ANY, "! ! !")),
    "instantActions": (
        *_HEADER,
        ("actions", Each(Record("instantAction")), "!=instantActions|actions ! !"),
    ),
    "zoneSet": (*_HEADER, ("zoneSet", Record("zones"), "- - !")),
    "zones": (
        ("mapId", ID, "- - !"),
        ("zoneSetId", ID, "- - !"),
        ("zoneSetDescriptor", TEXT, "- - o"),
        ("zones", Each(Record("zone")), "- - !"),
    ),
    "zone": (
        ("zoneId", ID, "- - !"),
        (
            "zoneType",
            words(
                "BLOCKED LINE_GUIDED RELEASE COORDINATED_REPLANNING SPEED_LIMIT ACTION PRIORITY"
                " PENALTY DIRECTED BIDIRECTED"
            ),
            "- - !",
        ),
        ("zoneDescriptor", TEXT, "- - o"),
        ("vertices", Each(Record("vertex"), least=3), "- - !"),
        ("maxSpeed", NUMBER, "- - o=maximumSpeed"),
        ("entryActions", Each(Record("zoneAction")), "- - o"),
        ("duringActions", Each(Record("zoneAction")), "- - o"),
        ("exitActions", Each(Record("zoneAction")), "- - o"),
        ("priorityFactor", SHARE, "- - o"),
        ("penaltyFactor", SHARE, "- - o"),
        ("direction", NUMBER, "- - o"),
        (
            "limitation",
            words("SOFT RESTRICTED STRICT"),
            "- - o=limitation|directedLimitation|bidirectedLimitation",
        ),
        ("releaseLossBehavior", words("STOP CONTINUE EVACUATE"), "- - o"),
    ),
    "vertex": (("x", NUMBER, "- - !"), ("y", NUMBER, "- - !")),
    "responses": (*_HEADER, ("responses", Each(Record("response")), "- - !")),
    "response": (
        ("requestId", ID, "- - !"),
        ("grantType", words("GRANTED QUEUED REVOKED REJECTED"), "- - !"),
        ("leaseExpiry", TIME, "- - o"),
    ),
    # From the robot.
    "connection": (
        *_HEADER,
        ("connectionState", words("ONLINE OFFLINE CONNECTIONBROKEN"), "! ! -"),
        (
            "connectionState",
            words("ONLINE OFFLINE HIBERNATING CONNECTIONBROKEN=CONNECTION_BROKEN"),
            "- - !",
        ),
    ),
    "visualization": (
        *_HEADER,
        ("referenceStateHeaderId", COUNT, "- - !"),
        ("agvPosition", Record("position"), "o o o=mobileRobotPosition"),
        ("velocity", Record("velocity"), "o o o"),
        ("plannedPath", Record("plannedPath"), "- - o"),
        ("intermediatePath", Record("intermediatePath"), "- - o"),
    ),
    "state": (
        *_HEADER,
        ("maps", Each(Record("mapState")), "- o o"),
        ("zoneSets", Each(Record("zoneSetState")), "- - o"),
        ("orderId", TEXT, "! ! !"),
        ("orderUpdateId", COUNT, "! ! !"),
        ("zoneSetId", TEXT, "o o -"),
        ("lastNodeId", TEXT, "! ! !"),
        ("lastNodeSequenceId", COUNT, "! ! !"),
        ("nodeStates", Each(Record("nodeState")), "! ! !"),
        ("edgeStates", Each(Record("edgeState")), "! ! !"),
        ("plannedPath", Record("plannedPath"), "- - o"),
        ("intermediatePath", Record("intermediatePath"), "- - o"),
        ("agvPosition", Record("position"), "o o o=mobileRobotPosition"),
        ("velocity", Record("velocity"), "o o o"),
        ("loads", Each(Record("load")), "o o o"),
        ("driving", FLAG, "! ! !"),
        ("paused", FLAG, "o o o"),
        ("newBaseRequest", FLAG, "o o o"),
        ("zoneRequests", Each(Record("zoneRequest")), "- - o"),
        ("edgeRequests", Each(Record("edgeRequest")), "- - o"),
        ("distanceSinceLastNode", NUMBER, "o o o"),
        ("actionStates", Each(Record("actionState")), "! ! !"),
        ("instantActionStates", Each(Record("actionState")), "- - !"),
        ("zoneActionStates", Each(Record("actionState")), "- - o"),
        ("batteryState", Record("battery"), "! ! !=powerSupply"),
        ("operatingMode", words("AUTOMATIC SEMIAUTOMATIC MANUAL SERVICE TEACHIN"), "! ! -"),
        (
            "operatingMode",
            words("STARTUP AUTOMATIC SEMIAUTOMATIC INTERVENED MANUAL SERVICE TEACHIN=TEACH_IN"),
            "- - !",
        ),
        ("errors", Each(Record("error")), "! ! !"),
        ("information", Each(Record("info")), "o o o"),
        ("safetyState", Record("safety"), "! ! !"),
    ),
    "mapState": (
        ("mapId", TEXT, "- ! !"),
        ("mapVersion", TEXT, "- ! !"),
        ("mapStatus", _ENABLED, "- ! !"),
    ),
    "zoneSetState": (
        ("zoneSetId", TEXT, "- - !"),
        ("mapId", TEXT, "- - !"),
        ("zoneSetStatus", _ENABLED, "- - !"),
    ),
    "nodeState": (
        ("nodeId", TEXT, "! ! !"),
        ("sequenceId", COUNT, "! ! !"),
        ("released", FLAG, "! ! !"),
        ("nodePosition", Record("nodePosition"), "o o o"),
    ),
    "edgeState": (
        ("edgeId", TEXT, "! ! !"),
        ("sequenceId", COUNT, "! ! !"),
        ("released", FLAG, "! ! !"),
        ("trajectory", Record("trajectory"), "o o o"),
    ),
    "plannedPath": (
        ("trajectory", Record("trajectory"), "- - !"),
        ("traversedNodes", Each(TEXT), "- - o"),
    ),
    "intermediatePath": (("polyline", Each(Record("pathPoint")), "- - !"),),
    "pathPoint": (
        ("x", NUMBER, "- - !"),
        ("y", NUMBER, "- - !"),
        ("theta", ANGLE, "- - o"),
        ("eta", TIME, "- - !"),
    ),
    "position": (
        ("x", NUMBER, "! ! !"),
        ("y", NUMBER, "! ! !"),
        ("theta", ANGLE, "! ! !"),
        ("mapId", TEXT, "! ! !"),
        ("positionInitialized", FLAG, "! ! !=localized"),
        ("localizationScore", SHARE, "o o o"),
        ("deviationRange", POSITIVE, "o o o"),
    ),
    "velocity": (("vx", NUMBER, "o o o"), ("vy", NUMBER, "o o o"), ("omega", NUMBER, "o o o")),
    "load": (("loadId", TEXT, "o o o"), ("loadType", TEXT, "o o o")),
    "zoneRequest": (
        ("requestId", TEXT, "- - !"),
        ("requestType", words("ACCESS REPLANNING"), "- - !"),
        ("zoneId", TEXT, "- - !"),
        ("zoneSetId", TEXT, "- - !"),
        ("requestStatus", _GRANTS, "- - !"),
        ("trajectory", Record("trajectory"), "- - o"),
    ),
    "edgeRequest": (
        ("requestId", TEXT, "- - !"),
        ("requestType", words("CORRIDOR"), "- - !"),
        ("edgeId", TEXT, "- - !"),
        ("sequenceId", COUNT, "- - !"),
        ("requestStatus", _GRANTS, "- - !"),
    ),
    "actionState": (
        ("actionId", TEXT, "! ! !"),
        ("actionType", TEXT, "o o o"),
        ("actionDescription", TEXT, "o o o=actionDescriptor"),
        ("actionStatus", words("WAITING INITIALIZING RUNNING PAUSED FINISHED FAILED"), "! ! -"),
        (
            "actionStatus",
            words("WAITING INITIALIZING RUNNING PAUSED RETRIABLE FINISHED FAILED"),
            "- - !",
        ),
        ("resultDescription", TEXT, "o o o=actionResult"),
    ),
    "battery": (
        ("batteryCharge", PERCENT, "! ! !=stateOfCharge"),
        ("batteryVoltage", NUMBER, "o o o"),
        ("charging", FLAG, "! ! !"),
        ("reach", POSITIVE, "o o o=range"),
    ),
    "error": (
        ("errorType", TEXT, "! ! !"),
        ("errorLevel", words("WARNING FATAL"), "! ! -"),
        ("errorLevel", words("WARNING URGENT CRITICAL FATAL"), "- - !"),
        ("errorDescription", TEXT, "o o o"),
        ("errorHint", TEXT, "- o o"),
        ("errorReferences", Each(Record("reference")), "o o o"),
    ),
    "info": (
        ("infoType", TEXT, "! ! !"),
        ("infoLevel", words("DEBUG INFO"), "! ! !"),
        ("infoDescription", TEXT, "o o o=infoDescriptor"),
        ("infoReferences", Each(Record("reference")), "o o o"),
    ),
    "reference": (("referenceKey", TEXT, "! ! !"), ("referenceValue", TEXT, "! ! !")),
    "safety": (
        ("eStop", words("AUTOACK MANUAL REMOTE NONE"), "! ! -"),
        ("eStop", words("MANUAL REMOTE NONE"), "- - !=activeEmergencyStop"),
        ("fieldViolation", FLAG, "! ! !"),
    ),
    "factsheet": (
        *_HEADER,
        ("typeSpecification", Record("typeSpecification"), "! ! !"),
        ("physicalParameters", Record("physicalParameters"), "! ! !"),
        ("protocolLimits", Record("protocolLimits"), "! ! !"),
        ("protocolFeatures", Record("protocolFeatures"), "! ! !"),
        ("agvGeometry", Record("geometry"), "! ! !=mobileRobotGeometry"),
        ("loadSpecification", Record("loadSpecification"), "! ! !"),
    ),
    "typeSpecification": (
        ("seriesName", TEXT, "! ! !"),
        ("agvKinematic", words("DIFF OMNI THREEWHEEL"), "! ! -"),
        (
            "agvKinematic",
            words("DIFF=DIFFERENTIAL OMNI=OMNIDIRECTIONAL THREEWHEEL=THREE_WHEEL"),
            "- - o=mobileRobotKinematics",
        ),
        ("agvClass", words("FORKLIFT CONVEYOR TUGGER CARRIER"), "! ! !=mobileRobotClass"),
        ("maxLoadMass", POSITIVE, "! ! !=maximumLoadMass"),
        ("localizationTypes", Each(words("NATURAL REFLECTOR RFID DMC SPOT GRID")), "! ! !"),
        (
            "navigationTypes",
            Each(words("PHYSICAL_LINE_GUIDED VIRTUAL_LINE_GUIDED AUTONOMOUS")),
            "! ! -",
        ),
        (
            "navigationTypes",
            Each(words("PHYSICAL_LINE_GUIDED VIRTUAL_LINE_GUIDED AUTONOMOUS=FREELY_NAVIGATING")),
            "- - !",
        ),
        ("supportedZones", Each(TEXT), "- - o"),
    ),
    "physicalParameters": (
        ("speedMin", NUMBER, "! ! !=minimumSpeed"),
        ("speedMax", NUMBER, "! ! !=maximumSpeed"),
        ("accelerationMax", NUMBER, "! ! !=maximumAcceleration"),
        ("decelerationMax", NUMBER, "! ! !=maximumDeceleration"),
        ("heightMin", NUMBER, "o o !=minimumHeight"),
        ("heightMax", NUMBER, "! ! !=maximumHeight"),
        ("width", NUMBER, "! ! !"),
        ("length", NUMBER, "! ! !"),
    ),
    "protocolLimits": (
        ("maxStringLens", Record("stringLengths"), "! ! !=maximumStringLengths"),
        ("maxArrayLens", Record("arrayLengths"), "! ! !=maximumArrayLengths"),
        ("timing", Record("timing"), "! ! !"),
    ),
    "stringLengths": (
        ("msgLen", COUNT, "o o o=maximumMessageLength"),
        ("idLen", COUNT, "o o o=maximumIdLength"),
    ),
    "arrayLengths": tuple(
        (name, COUNT, "o o o")
        for name in ("order.nodes", "order.edges", "node.actions", "edge.actions")
    ),
    "timing": (
        ("minOrderInterval", NUMBER, "! ! !=minimumOrderInterval"),
        ("minStateInterval", NUMBER, "! ! !=minimumStateInterval"),
        ("defaultStateInterval", NUMBER, "o o o"),
        ("visualizationInterval", NUMBER, "o o o"),
    ),
    "protocolFeatures": (
        ("optionalParameters", Each(Record("optionalParameter")), "! ! !"),
        ("agvActions", Each(Record("offer")), "! ! !=mobileRobotActions"),
    ),
    "optionalParameter": (
        ("parameter", TEXT, "! ! !"),
        ("support", words("SUPPORTED REQUIRED"), "! ! !"),
        ("description", TEXT, "o o o"),
    ),
    "offer": (
        ("actionType", TEXT, "! ! !"),
        ("actionDescription", TEXT, "o o o"),
        ("actionScopes", Each(words("INSTANT NODE EDGE")), "! ! -"),
        ("actionScopes", Each(words("INSTANT NODE EDGE ZONE")), "- - !"),
        ("actionParameters", Each(Record("offerParameter")), "o o o"),
        ("pauseAllowed", FLAG, "- - !"),
        ("cancelAllowed", FLAG, "- - !"),
    ),
    "offerParameter": (
        ("key", TEXT, "! ! !"),
        ("valueDataType", words("BOOL NUMBER INTEGER FLOAT STRING OBJECT ARRAY"), "! ! -"),
        ("valueDataType", words("BOOL FLOAT=NUMBER INTEGER STRING OBJECT ARRAY"), "- - !"),
        ("isOptional", FLAG, "o o o"),
    ),
    "geometry": (("envelopes2d", Each(Record("envelope")), "o o o"),),
    "envelope": (
        ("set", TEXT, "! ! !=envelope2dId"),
        ("polygonPoints", Each(Record("corner")), "! ! !=vertices"),
    ),
    "corner": (("x", NUMBER, "! ! !"), ("y", NUMBER, "! ! !")),
    "loadSpecification": (
        ("loadPositions", Each(TEXT), "o o o"),
        ("loadSets", Each(Record("loadSet")), "o o o"),
    ),
    "loadSet": (("setName", TEXT, "! ! !"), ("loadType", TEXT, "! ! !")),
}
NEEDS = {  # further fields that zones of a type need
    "SPEED_LIMIT": ("maxSpeed",),
    "ACTION": ("entryActions", "duringActions", "exitActions"),
    "PRIORITY": ("priorityFactor",),
    "PENALTY": ("penaltyFactor",),
    "DIRECTED": ("direction", "limitation"),
    "BIDIRECTED": ("direction", "limitation"),
}


def _by_version() -> dict[str, dict[str, dict[str, WireField]]]:
    """Return the fields by version, table and name on the wire; the first name is written."""
    tables: dict[str, dict[str, dict[str, WireField]]] = {version: {} for version in VERSIONS}
    for table, rows in _ROWS.items():
        for version in VERSIONS:
            tables[version][table] = {}
        for inside, kind, presence in rows:
            for version, mark in zip(VERSIONS, presence.split(), strict=True):
                code, _, wires = mark.partition("=")
                for wire in (wires or inside).split("|") if code != "-" else ():
                    tables[version][table][wire] = WireField(inside, kind, code == "!")
    return tables


TABLES = _by_version()


def wire_name(version: str, table: str, inside: str) -> str:
    """Return the name of a field on the wire; empty if the version has none.

    Args:
        inside: Name inside the package, like `maxSpeed`.
    """
    names = (wire for wire, each in TABLES[version][table].items() if each.inside == inside)
    return next(names, "")


def versions_of(table: str, wire: str) -> list[str]:
    """Return the versions in which a table has a field of a name."""
    return [version for version in VERSIONS if wire in TABLES[version][table]]
