"""A small report made by hand: a level in centimetres, y up, three goals, and any findings asked for."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.records import (
    Character,
    Exploration,
    ExploreSettings,
    Finding,
    Frame,
    GateSettings,
    Level,
    NavMesh,
    Origin,
    Points,
    ReplayPath,
    Report,
    Required,
    Solid,
    Spawn,
    StopReason,
    Verdict,
    Zone,
)
from reachtest.report import build_document

PASS = Verdict("pass", 0, "nothing that gates was found")
FAIL = Verdict("fail", 1, "2 findings that gate: 1 fell out of world, 1 unexpected area")
INCONCLUSIVE = Verdict("inconclusive", 4, "only 2 of 3 goals were reached (100 % wanted)")
LONG = Verdict(
    "inconclusive", 4, f"{'so much was not explored; ' * 12}likely to take 523,000 more steps", 523_000
)

Y_UP_CM = Frame(0.01 * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]), "y", "cm")
FLOOR = np.array([[[0, 0, 0], [8, 0, 0], [8, 8, 0]], [[0, 0, 0], [8, 8, 0], [0, 8, 0]]], dtype=np.float64)


def make_level(**changes: Any) -> Level:
    """An 8 x 8 m floor."""
    level = Level(
        name="hall",
        file=Path("/somewhere/on/a/disk/hall.yaml"),
        sha256="ab" * 32,
        frame=Y_UP_CM,
        collision=FLOOR,
        solids=(Solid("pillar", FLOOR),),
        parts=(),
        navmesh=NavMesh("hall.nav.glb", FLOOR.reshape(-1, 3), np.arange(6, dtype=np.int64).reshape(2, 3)),
        character=Character(0.34, 1.76, 6.0, 4.2, 0.45, 44.765, 9.8, 40.0, 20.48, 20.48, 8.0, 0.05),
        spawns=(Spawn("start", np.array([1.0, 1.0, 0.0])),),
        kill_z_m=-10.0,
        bounds=(np.array([-20.0, -20.0, -10.0]), np.array([28.0, 28.0, 30.0])),
        zones=(Zone("vault", "forbidden", np.array([6.0, 6.0, 0.0]), np.array([8.0, 8.0, 3.0])),),
        required=(Required("door", np.array([7.0, 1.0, 0.0]), 1.0),),
        explore=ExploreSettings(),
        gate=GateSettings(("unexpected_area", "fell_out_of_world")),
    )
    return dataclasses.replace(level, **changes)


def make_exploration(**changes: Any) -> Exploration:
    """Four points, one of them off the nav-mesh; two of three goals reached."""
    positions = np.array([[1, 1, 0], [3, 1, 0], [5, 1, 0], [12, 1, -2]], dtype=np.float64)
    exploration = Exploration(
        points=Points(
            positions=positions,
            states=np.zeros((4, 2)),
            grounded=np.ones(4, dtype=np.bool_),
            parent=np.array([-1, 0, 1, 2], dtype=np.int32),
            round=np.zeros(4, dtype=np.int32),
            agent=np.zeros(4, dtype=np.int16),
            start=np.zeros(4, dtype=np.int16),
            step=np.arange(4, dtype=np.int16),
            off_mesh_m=np.array([0.0, 0.1, 0.0, np.inf]),
            exit_point=np.full((4, 3), np.nan),
        ),
        visits=np.array([9, 4, 2, 1]),
        goals=positions[:3],
        goal_step=np.array([0, 640, -1]),
        required_step=np.array([1_200]),
        falls=(),
        agent_steps=200_000,
        episodes=1_563,
        diverged_episodes=0,
        cells_once=12,
        cells_twice=6,
        cells_total=410,
        stop_reason=StopReason.STEPS,
        seed=7,
        settings=ExploreSettings(),
        timing={"wall_s": 63.2, "physics_s": 41.0, "cache_s": 9.5, "rest_s": 12.7, "threads": 2.0},
    )
    return dataclasses.replace(exploration, **changes)


def make_finding(**changes: Any) -> Finding:
    """Fell out of the world at (4, 3, -10), having left the nav-mesh at (4, 2, 0)."""
    finding = Finding(
        id="fell-5f2a91",
        kind="fell_out_of_world",
        severity="error",
        gating=True,
        title="Falls out of the world beside floor_12",
        position=np.array([4.0, 3.0, -10.0]),
        low=np.array([3.0, 2.5, -10.0]),
        high=np.array([5.0, 3.5, -9.9]),
        points=14,
        exit_point=np.array([4.0, 2.0, 0.0]),
        nearest_named="floor_12",
        first_seen_step=5_120,
        path=make_path(),
        suppressed_by=None,
    )
    return dataclasses.replace(finding, **changes)


def make_path() -> ReplayPath:
    """Two episodes, 9.6 s."""
    steps = np.linspace([1.0, 1.0, 0.0], [4.0, 3.0, -10.0], 72)
    episodes = (Origin(-1, 0, 3, 0, 40), Origin(17, 2, 5, 0, 31))
    return ReplayPath(np.array([1.0, 1.0, 0.0]), episodes, steps, 9.6, 5, 5)


def make_findings() -> tuple[Finding, ...]:
    """One of each sort: two that gate, one whose kind does not, one suppressed."""
    area = make_finding(
        id="area-0c11d4",
        kind="unexpected_area",
        title="Gets onto roof_west, 6.4 m off the nav-mesh",
        position=np.array([12.0, 1.0, 5.2]),
        low=np.array([9.0, 0.0, 5.0]),
        high=np.array([17.0, 3.2, 6.1]),
        points=41,
        nearest_named="roof_west",
    )
    stuck = make_finding(
        id="stuck-77e0b2",
        kind="stuck",
        severity="warning",
        gating=False,
        title="Cannot move any more between crate_3 and wall_9",
        position=np.array([2.0, 6.0, 0.0]),
        points=1,
        exit_point=None,
        nearest_named="crate_3",
    )
    known = make_finding(id="area-99aa01", gating=False, suppressed_by="baseline.json", path=None)
    return make_finding(), area, stuck, known


def make_report(
    findings: tuple[Finding, ...] = (),
    verdict: Verdict = PASS,
    level: Level | None = None,
    exploration: Exploration | None = None,
) -> Report:
    """A whole report, its document built by `build_document`."""
    level = level or make_level()
    if exploration is None:
        reached = {"goal_step": np.array([0, 640, 902])} if verdict is PASS else {}
        exploration = make_exploration(**reached)
    version, started_at = "0.1.0", "2024-05-01T12:00:00+00:00"
    document = build_document(level, exploration, findings, verdict, version, started_at)
    return Report(level, exploration, findings, verdict, version, started_at, document)
