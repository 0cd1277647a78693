"""Factsheet of a robot model, as the fleet control reads it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from swarm_common.model.records import RobotSpec
from swarm_vda5050.actions import PAUSABLE, ActionOffer
from swarm_vda5050.dialect import LARGEST
from swarm_vda5050.order_check import MOST_ACTIONS, MOST_NODES
from swarm_vda5050.standard import LONGEST_ID, wire_name
from swarm_vda5050.zones import SUPPORTED

OF_EDGES = (  # optional fields that robots heed
    "maxSpeed",
    "trajectory",
    "corridor",
    "orientation",
    "orientationType",
    "rotationAllowed",
    "reachOrientationBeforeEntering",
    "direction",
)


def factsheet(spec: RobotSpec, offered: Mapping[str, ActionOffer], version: str) -> dict[str, Any]:
    """Return the content of a factsheet, with the names inside the package.

    Args:
        offered: Actions of the version, by actionType.
        version: Like `2.1`.
    """
    xs, ys = ([point[axis] for point in spec.footprint] for axis in (0, 1))
    supported = [f"edges.{wire}" for name in OF_EDGES if (wire := wire_name(version, "edge", name))]
    if retriable := wire_name(version, "action", "retriable"):
        supported += [f"{part}.actions.{retriable}" for part in ("nodes", "edges")]
    return {
        "typeSpecification": {
            "seriesName": spec.model,
            "agvKinematic": "OMNI" if spec.is_omni else "DIFF",
            "agvClass": "CARRIER",
            "maxLoadMass": 0.0,
            "localizationTypes": ["NATURAL"],
            "navigationTypes": ["AUTONOMOUS"],
            "supportedZones": list(SUPPORTED),
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
                *({"parameter": f"order.{name}", "support": "SUPPORTED"} for name in supported),
            ],
            "agvActions": [_action(name, offer) for name, offer in offered.items()],
        },
        "agvGeometry": {
            "envelopes2d": [
                {"set": "footprint", "polygonPoints": [{"x": x, "y": y} for x, y in spec.footprint]}
            ]
        },
        "loadSpecification": {"loadPositions": [""], "loadSets": []},
    }


def _action(name: str, offer: ActionOffer) -> dict[str, Any]:
    return {
        "actionType": name,
        "actionDescription": offer.about,
        "actionScopes": [scope.value for scope in offer.scopes],
        "actionParameters": [
            {"key": key, "valueDataType": kind, "isOptional": key not in offer.required}
            for key, kind in (offer.required | offer.optional).items()
        ],
        "pauseAllowed": name in PAUSABLE,
        "cancelAllowed": True,
    }


def localization_score(deviation: float) -> float:
    """Return a score from 0 to 1 for a standard deviation [m] of the position."""
    return math.exp(-deviation)
