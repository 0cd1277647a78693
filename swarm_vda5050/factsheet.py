"""Factsheet of a robot model, as the fleet control reads it."""

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
KINEMATICS_OF_3 = {"OMNI": "OMNIDIRECTIONAL", "DIFF": "DIFFERENTIAL"}


def factsheet(spec: RobotSpec, offered: Mapping[str, ActionOffer], major: int) -> dict[str, Any]:
    """Return the content of a factsheet, with the names of 2.1.

    Args:
        offered: Actions of the version, by actionType.
        major: 2 or 3, whose values differ.
    """
    xs, ys = ([point[axis] for point in spec.footprint] for axis in (0, 1))
    kinematic = "OMNI" if spec.is_omni else "DIFF"
    speed_limit = "order.edges.maxSpeed" if major == 2 else "order.edges.maximumSpeed"
    supported = (speed_limit, "order.edges.trajectory", "order.edges.corridor")
    return {
        "typeSpecification": {
            "seriesName": spec.model,
            "agvKinematic": kinematic if major == 2 else KINEMATICS_OF_3[kinematic],
            "agvClass": "CARRIER",
            "maxLoadMass": 0.0,
            "localizationTypes": ["NATURAL"],
            "navigationTypes": ["AUTONOMOUS" if major == 2 else "FREELY_NAVIGATING"],
            **({} if major == 2 else {"supportedZones": list(SUPPORTED)}),
        },
        "physicalParameters": {
            "speedMin": 0.0,
            "speedMax": max(spec.max_vel_x, spec.max_vel_y),
            "accelerationMax": spec.acc_lim_x,
            "decelerationMax": spec.acc_lim_x,
            "heightMin": spec.height,
            "heightMax": spec.height,
            "width": max(ys) - min(ys),
            "length": max(xs) - min(xs),
        },
        "protocolLimits": {
            "maxStringLens": {"msgLen": LARGEST, "idLen": LONGEST_ID},
            "maxArrayLens": {
                "order.nodes": MOST_NODES,
                "order.edges": MOST_NODES - 1,
                "node.actions": MOST_ACTIONS,
                "edge.actions": MOST_ACTIONS,
            },
            "timing": {
                "minOrderInterval": 0.0,
                "minStateInterval": 0.1,
                "defaultStateInterval": 30.0,
            },
        },
        "protocolFeatures": {
            "optionalParameters": [
                {"parameter": "order.nodes.nodePosition", "support": "REQUIRED"},
                *({"parameter": name, "support": "SUPPORTED"} for name in supported),
            ],
            "agvActions": [_action(name, offer, major) for name, offer in offered.items()],
        },
        "agvGeometry": {
            "envelopes2d": [
                {"set": "footprint", "polygonPoints": [{"x": x, "y": y} for x, y in spec.footprint]}
            ]
        },
        "loadSpecification": {"loadPositions": [""], "loadSets": []},
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
    promises = (
        {}
        if major == 2
        else {"pauseAllowed": str(name in PAUSABLE).lower(), "cancelAllowed": "true"}
    )
    return promises | {
        "actionType": name,
        "actionDescription": offer.about,
        "actionScopes": [scope.value for scope in offer.scopes],
        "actionParameters": parameters,
    }


def localization_score(deviation: float) -> float:
    """Return a score from 0 to 1 for a standard deviation [m] of the position."""
    return math.exp(-deviation)
