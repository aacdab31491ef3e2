"""Places one can get into and not out of, after directed attempts: small ones hold the character, large ones do not
lead back to a spawn."""

from __future__ import annotations

import numpy as np

from reachtest.findings.build import Cluster
from reachtest.findings.evidence import Evidence
from reachtest.records import Pocket


def stuck_places(evidence: Evidence) -> list[Cluster]:
    """Pockets of a few metres that no attempt left."""
    return [_cluster("stuck", pocket, evidence) for pocket in evidence.exploration.pockets if pocket.stuck]


def no_returns(evidence: Evidence) -> list[Cluster]:
    """Larger regions that nothing leads back from.

    What lies off the nav-mesh altogether is left out: the way there is an `unexpected_area` already.
    """
    expected = evidence.exploration.points.expected
    return [
        _cluster("no_return", pocket, evidence)
        for pocket in evidence.exploration.pockets
        if not pocket.stuck and (not len(pocket.points) or expected[pocket.points].any())
    ]


def _cluster(kind: str, pocket: Pocket, evidence: Evidence) -> Cluster:
    cached = evidence.exploration.points.positions[pocket.points]
    return Cluster(
        kind=kind,
        label="",
        points=pocket.points,
        falls=() if len(pocket.points) else (pocket.arrival,),
        places=pocket.cells,
        standing=np.concatenate([pocket.cells, cached]),
        reach_m=pocket.reach_m,
        details=_details(pocket),
        count=len(pocket.cells),
    )


def _details(pocket: Pocket) -> tuple[str, ...]:
    minutes, seconds = divmod(round(pocket.sim_time_s), 60)
    if pocket.stuck:
        outcome = f"no attempt got farther than {pocket.reach_m:.1f} m from where it began"
    else:
        outcome = (
            "no attempt found a way to a place that leads back to a spawn, or to its part of the nav-mesh"
        )
    return (
        f"{pocket.attempts} directed attempts in all 8 directions, walking and jumping, {minutes} min {seconds} s"
        " of play",
        outcome,
        f"they passed through {pocket.volume_m3:,.0f} m3",
    )
