"""Settings that swarm-up gives the recorder process, and the place of the bag."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from swarm_run.plan import RunPlan

FILE = "recording.mcap"


def recorder_config(plan: RunPlan, folder: Path) -> dict[str, Any]:
    """Return the configuration of the recorder; the facts about the run are kept in the bag."""
    spec = plan.spec
    models = [member.model for member in plan.fleet.members]
    about = {
        "world": str(plan.world),
        "sites": str(plan.sites_path or ""),
        "robots": json.dumps(dict(zip(spec.robot_names, models, strict=True))),
        "mission": spec.mission or "",
        "seed": str(spec.seed),
    }
    return {
        "path": str(folder / FILE),
        "robots": spec.robot_names,
        "topics": spec.record_topics,
        "rate": spec.record_rate,
        "about": about,
        "awaited": list(plan.alive),
    }
