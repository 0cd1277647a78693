"""What a robot model can do, as the fleet control reads it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from swarm_common.model.records import RobotSpec
from swarm_vda5050.actions import PAUSABLE, ActionOffer
from swarm_vda5050.dialect import LARGEST
from swarm_vda5050.order_check import LONGEST_ID, MOST_ACTIONS, MOST_NODES
from swarm_vda5050.zones import SUPPORTED

NUMBER = "NUMBER"  # of 3.0, which has no FLOAT


def factsheet(spec: RobotSpec, offered: Mapping[str, ActionOffer], major: int) -> dict[str, Any]:
    """Return the content of a factsheet.

    Args:
        offered: Actions of the version, by actionType.
        major: 2 or 3.
    """
    xs, ys = ([point[axis] for point in spec.footprint] for axis in (0, 1))
    robot, suffix = ("agv", "") if major == 2 else ("mobileRobot", "imum")
    speed = max(spec.max_vel_x, spec.max_vel_y)
    kinematic = "OMNI" if spec.is_omni else "DIFF"
    return {
        "typeSpecification": {
            "seriesName": spec.model,
            **({"agvKinematic": kinematic} if major == 2 else _of_3(kinematic)),
            f"{robot}Class": "CARRIER",
            f"max{suffix}LoadMass": 0.0,
            "localizationTypes": ["NATURAL"],
            "navigationTypes": ["AUTONOMOUS" if major == 2 else "FREELY_NAVIGATING"],
        },
        "physicalParameters": _physical(spec, speed, max(xs) - min(xs), max(ys) - min(ys), major),
        "protocolLimits": _limits(major),
        "protocolFeatures": {
            "optionalParameters": [
                {"parameter": "order.nodes.nodePosition", "support": "REQUIRED"},
                *(
                    {"parameter": f"order.edges.{name}", "support": "SUPPORTED"}
                    for name in (f"max{suffix}Speed", "trajectory", "corridor")
                ),
            ],
            f"{robot}Actions": [_action(name, offer, major) for name, offer in offered.items()],
        },
        f"{robot}Geometry": {
            "envelopes2d": [
                {
                    "set" if major == 2 else "envelope2dId": "footprint",
                    "polygonPoints" if major == 2 else "vertices": [
                        {"x": x, "y": y} for x, y in spec.footprint
                    ],
                }
            ]
        },
        "loadSpecification": {"loadPositions": [""], "loadSets": []},
    }


def _of_3(kinematic: str) -> dict[str, Any]:
    names = {"OMNI": "OMNIDIRECTIONAL", "DIFF": "DIFFERENTIAL"}
    return {"mobileRobotKinematics": names[kinematic], "supportedZones": list(SUPPORTED)}


def _physical(
    spec: RobotSpec, speed: float, length: float, width: float, major: int
) -> dict[str, float]:
    short = {
        "speedMin": 0.0,
        "speedMax": speed,
        "accelerationMax": spec.acc_lim_x,
        "decelerationMax": spec.acc_lim_x,
        "heightMin": spec.height,
        "heightMax": spec.height,
        "width": width,
        "length": length,
    }
    if major == 2:
        return short
    names = {"Min": "minimum", "Max": "maximum"}
    return {
        names[key[-3:]] + key[:-3].capitalize() if key[-3:] in names else key: value
        for key, value in short.items()
    }


def _limits(major: int) -> dict[str, Any]:
    strings = {"msgLen": LARGEST, "idLen": LONGEST_ID}
    arrays = {
        "order.nodes": MOST_NODES,
        "order.edges": MOST_NODES - 1,
        "node.actions": MOST_ACTIONS,
        "edge.actions": MOST_ACTIONS,
    }
    timing = {"minOrderInterval": 0.0, "minStateInterval": 0.1, "defaultStateInterval": 30.0}
    if major == 2:
        return {"maxStringLens": strings, "maxArrayLens": arrays, "timing": timing}
    return {
        "maximumStringLengths": {"maximumMessageLength": LARGEST, "maximumIdLength": LONGEST_ID},
        "maximumArrayLengths": arrays,
        "timing": {
            "minimumOrderInterval": 0.0,
            "minimumStateInterval": 0.1,
            "defaultStateInterval": 30.0,
        },
    }


def _action(name: str, offer: ActionOffer, major: int) -> dict[str, Any]:
    parameters = [
        {
            "key": key,
            "valueDataType": NUMBER if kind == "FLOAT" and major == 3 else kind,
            "isOptional": key not in offer.required,
        }
        for key, kind in (offer.required | offer.optional).items()
    ]
    promises = {} if major == 2 else {
        "pauseAllowed": str(name in PAUSABLE).lower(), "cancelAllowed": "true",
    }  # fmt: skip
    return promises | {
        "actionType": name,
        "actionDescription": offer.about,
        "actionScopes": [scope.value for scope in offer.scopes],
        "actionParameters": parameters,
    }


def localization_score(deviation: float) -> float:
    """Return a score from 0 to 1 for a standard deviation [m] of the position."""
    return math.exp(-deviation)
