"""What the exploration shows, before it is called a bug: which points lie where, and how long the way was.

Shape legend: P cached points, n chosen ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import rtree

from reachtest.interfaces import Replayer
from reachtest.navmesh.itself import NavMeshItself
from reachtest.navmesh.survey import Survey
from reachtest.offlimits import off_limits
from reachtest.records import Bools, Exploration, Fall, Floats, Ints, Level, Origin

_SAME_M = 1e-3  # parts as near as this are equally near


@dataclass(frozen=True)
class Evidence:
    """The exploration of one level, with what several detectors ask for worked out once."""

    level: Level
    exploration: Exploration
    replayer: Replayer
    known_survey: Survey | None = None  # where it has been worked out already

    @cached_property
    def survey(self) -> Survey:
        """The nav-mesh's islands, and what it promises in vain."""
        return self.known_survey or Survey(self.level, self.exploration)

    @cached_property
    def steps_from_spawn(self) -> Ints:
        """Length [P] of the known way to each point [agent steps]."""
        points = self.exploration.points
        length = (points.step - points.start).astype(np.int64)
        for index, parent in enumerate(points.parent.tolist()):
            if parent >= 0:  # parents come before their children
                length[index] += length[parent]
        return length

    def steps_of_fall(self, fall: Fall) -> int:
        """Length of the known way to a fall [agent steps]."""
        parent = fall.origin.parent
        return (
            fall.origin.step - fall.origin.start + (int(self.steps_from_spawn[parent]) if parent >= 0 else 0)
        )

    @cached_property
    def off_limits(self) -> dict[tuple[str, str], Bools]:
        """The points [P] that are in each solid and forbidden zone, by kind of finding and name."""
        positions = self.exploration.points.positions
        return {(one.kind, one.name): one.holds(positions) for one in off_limits(self.level)}

    @cached_property
    def allowed(self) -> Bools:
        """The points [P] in zones where one may be off the nav-mesh."""
        positions = self.exploration.points.positions
        zones = [zone.holds(positions) for zone in self.level.zones if zone.kind == "allowed_off_mesh"]
        return np.logical_or.reduce([np.zeros(len(positions), dtype=np.bool_), *zones])

    @cached_property
    def navmesh_itself(self) -> NavMeshItself:
        """Tells where a way left the nav-mesh."""
        return NavMeshItself(self.level)

    def seen_step(self, origin: Origin) -> int:
        """The agent step of the run at which something of `origin` was seen first."""
        s = self.exploration.settings
        return origin.round * s.reset_interval * s.lanes + (origin.step - 1) * s.lanes + origin.agent + 1

    def nearest_part(self, position: Floats) -> str | None:
        """The name of the level part whose box is nearest to a position [3]; the smaller of equals."""
        if not self.level.parts:
            return None

        nearest = next(self._part_boxes.nearest((*position, *position), 1))
        reach = self._away(nearest, position) + 2 * _SAME_M
        near = self._part_boxes.intersection((*(position - reach), *(position + reach)))

        def rank(index: int) -> tuple[float, float, int]:
            part = self.level.parts[index]
            away = round(self._away(index, position) / _SAME_M)
            return away, float(np.prod(part.high - part.low + 0.01)), index

        return self.level.parts[min(near, key=rank)].name

    @cached_property
    def _part_boxes(self) -> rtree.index.Index:
        """The parts' boxes in an R*-tree: a city has thousands."""
        properties = rtree.index.Property(dimension=3, variant=rtree.index.RT_Star)
        boxes = ((i, (*part.low, *part.high), None) for i, part in enumerate(self.level.parts))
        return rtree.index.Index(boxes, properties=properties)

    def _away(self, index: int, position: Floats) -> float:
        """Distance of `position` [3] from the box of a part [m]."""
        part = self.level.parts[index]
        return float(np.linalg.norm(np.maximum(np.maximum(part.low - position, position - part.high), 0.0)))
