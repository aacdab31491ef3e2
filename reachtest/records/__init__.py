"""The records that cross between stages: frozen, with shapes and units.

Positions are the character's *feet* in level coordinates: metres, z up, float64, unless said otherwise.
"""

from __future__ import annotations

from reachtest.records.arrays import (
    Bools,
    Floats,
    Ints,
)
from reachtest.records.exploration import (
    Candidates,
    EndReason,
    Exploration,
    Fall,
    Origin,
    Pocket,
    Points,
    RoundRecord,
    StepResult,
    StopReason,
)
from reachtest.records.level import (
    Character,
    Frame,
    HeightField,
    Level,
    NavAgent,
    NavLink,
    NavMesh,
    Part,
    Required,
    Solid,
    Spawn,
    Zone,
)
from reachtest.records.report import (
    KINDS,
    SEVERITIES,
    Confirmation,
    Finding,
    ReplayPath,
    Report,
    Verdict,
)
from reachtest.records.risk import SATURATED_RISK, RiskSample
from reachtest.records.settings import (
    OUTWARDS,
    ExploreSettings,
    GateSettings,
)

__all__ = [
    "KINDS",
    "OUTWARDS",
    "SATURATED_RISK",
    "SEVERITIES",
    "Bools",
    "Candidates",
    "Character",
    "Confirmation",
    "EndReason",
    "Exploration",
    "ExploreSettings",
    "Fall",
    "Finding",
    "Floats",
    "Frame",
    "GateSettings",
    "HeightField",
    "Ints",
    "Level",
    "NavAgent",
    "NavLink",
    "NavMesh",
    "Origin",
    "Part",
    "Pocket",
    "Points",
    "ReplayPath",
    "Report",
    "Required",
    "RiskSample",
    "RoundRecord",
    "Solid",
    "Spawn",
    "StepResult",
    "StopReason",
    "Verdict",
    "Zone",
]
