"""Probes: directed attempts to get out of regions that nothing found leads out of. What none leaves is a pocket.

Shape legend: B lanes, T agent steps of an episode, P cached points, N places of the transition graph, n chosen ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reachtest.explore.actions import JUMP_SHARE, heading_of, start_generator
from reachtest.explore.attempts import Attempt, Attempts, Front
from reachtest.explore.graph import UNKNOWN, lies
from reachtest.explore.regions import Region, TrapFinder, Trapped
from reachtest.explore.replay import Replayer
from reachtest.explore.stays import Stays
from reachtest.explore.transitions import Transitions
from reachtest.interfaces import Simulator, Teller
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Fall, Ints, Level, Origin, Pocket, Points

ATTEMPTS = 256  # episodes that try to leave a region before it is called one without a way out
ATTEMPTS_A_PLACE = 1  # more for every cell of it: a hall has many doors
BORDER = (
    64  # places of a region nearest to a way back, at most a quarter of it if that is more than an eighth
)
NUDGE_M = 0.03  # more than a jammed contact needs, less than any ledge
SWEEPS = 24  # rounds of an episode from every trap first: most were merely found last
LANES_A_REGION = 32  # at once at least: each of eight headings with each of JUMPS
CHAIN = 4  # episodes that go on from each other's end: out of a maze takes longer than one
JUMPS = (0.0, JUMP_SHARE, 0.5, 0.9)  # shares of the holds: walking, as usual, and on purpose
STEPS_SHARE = 0.1  # of the run's agent steps at most are probes, or LEAST_STEPS
LEAST_STEPS = 400_000  # enough for some tens of regions after a short run; where there are none few are made


@dataclass(frozen=True)
class Probed:
    """What the probes found and cost."""

    pockets: tuple[Pocket, ...]
    episodes: int
    steps: int  # [agent steps]


class Prober:
    """Probes the regions of one exploration; enters what it finds into its transitions."""

    def __init__(
        self,
        level: Level,
        simulator: Simulator,
        transitions: Transitions,
        replayer: Replayer,
        seed: int,
        first_round: int,
    ) -> None:
        """`first_round` is the first that is not the exploration's: probes have streams of their own."""
        self._level, self._simulator, self._transitions = level, simulator, transitions
        self._replayer, self._seed = replayer, seed
        self._budget = max(LEAST_STEPS, int(STEPS_SHARE * level.explore.steps))
        self._attempts = Attempts(level.explore, simulator, transitions, seed, first_round)

    def run(
        self,
        points: Points,
        islands: Islands,
        interrupted: Callable[[], bool] = lambda: False,
        tell: Teller = lambda what, number, total: None,
    ) -> Probed:
        """The pockets, with the cached points in them; those known by then, if `interrupted`.

        `islands` are those of the level's nav-mesh.
        """
        finder = TrapFinder(self._level, islands)
        trapped = finder.find(self._transitions.graph())
        few = self._simulator.agents // LANES_A_REGION
        for _ in range(SWEEPS):
            if len(trapped.regions) <= few or self._attempts.steps >= self._budget or interrupted():
                break
            tell("looking for pockets", 1, len(trapped.regions))
            self._sweep(trapped)
            trapped = finder.find(self._transitions.graph(), trapped.suspects)
        while self._attempts.steps < self._budget and not interrupted():
            open_ = [region for region in trapped.regions if not self._done(trapped, region)]
            if not open_:
                break
            tell("looking for pockets", len(trapped.regions) - len(open_) + 1, len(trapped.regions))
            open_.sort(key=lambda region: len(self._tried(trapped, region)))  # what is none falls away early
            self._besiege(trapped, open_[: max(1, few)])
            trapped = finder.find(self._transitions.graph(), trapped.suspects)
        pockets = [
            self._pocket(trapped, region, points) for region in trapped.regions if self._done(trapped, region)
        ]
        return Probed(tuple(pockets), self._attempts.episodes, self._attempts.steps)

    # --- probing ----------------------------------------------------------------------------------

    def _sweep(self, trapped: Trapped) -> None:
        """An episode or more from every region, towards the nearest place that leads back."""
        rng, agents = start_generator(self._seed, self._attempts.round), self._simulator.agents
        often = max(1, agents // len(trapped.regions))
        rows = np.array([rng.choice(self._known(trapped, region)) for region in trapped.regions * often])
        for begin in range(0, len(rows), agents):
            front = self._front(trapped, rows[begin : begin + agents])
            count = len(front.states)
            anywhere = rng.integers(1, 9, count)  # what is nearest may be behind a wall
            headings = np.where(rng.random(count) < 0.5, self._back(trapped, front), anywhere)
            self._attempts.run(front, headings, np.array(JUMPS)[rng.integers(1, len(JUMPS), count)])

    def _besiege(self, trapped: Trapped, regions: list[Region]) -> None:
        """Episodes from all over the regions in all directions, and on from where they ended."""
        rng = start_generator(self._seed, self._attempts.round)
        each = max(1, self._simulator.agents // len(regions))
        rows = np.concatenate(
            [self._starts(rng, trapped, region, self._numbers(each, each)) for region in regions]
        )
        number = self._numbers(len(rows), each)
        jumps = np.array(JUMPS)[number // 8 % len(JUMPS)]
        front = self._nudged(rng, self._front(trapped, rows), number // 8 % 2 == 1)
        for episode in range(CHAIN):
            around = (number + episode) % 8 + 1
            headings = self._back(trapped, front) if episode % 2 else around
            front = self._attempts.run(front, headings, jumps)

    def _numbers(self, lanes: int, each: int) -> Ints:
        """Numbers [lanes] that say which way and how a region's `each` attempts go; few lanes take turns at them."""
        turn = self._attempts.round // CHAIN * each if each < LANES_A_REGION else 0
        return turn + np.arange(lanes) % each

    def _starts(self, rng: np.random.Generator, trapped: Trapped, region: Region, number: Ints) -> Ints:
        """Where to start from: where one ends up; on the way there, which may fork; where a way back is near."""
        places = trapped.graph.places
        count = len(number)
        known = region.rows[trapped.graph.origins[region.rows, 0] != UNKNOWN]
        core, any_ = rng.choice(self._known(trapped, region), count), rng.choice(known, count)
        away = np.linalg.norm(places[known] - trapped.way_back(places[known]), axis=1)
        nearest = max(min(BORDER, len(known) // 4), len(known) // 8, 1)
        border = rng.choice(known[np.argsort(away, kind="stable")[:nearest]], count)
        return np.choose(number // 16 % 4, [core, border, core if region.stuck else border, any_])

    def _known(self, trapped: Trapped, region: Region) -> Ints:
        """The places of a region that the exploration got to itself: where one ends up, if possible."""
        known = trapped.graph.origins[:, 0] != UNKNOWN
        core = region.core[known[region.core]]
        return core if len(core) else region.rows[known[region.rows]]

    def _front(self, trapped: Trapped, rows: Ints) -> Front:
        """The characters as they were at places `rows` [n]."""
        graph = trapped.graph
        keys, states = graph.keys[rows], graph.states[rows]
        began = np.flatnonzero(np.isnan(states[:, 0]))
        origins = [Origin(*row) for row in graph.origins[rows[began]].tolist()]
        if origins:
            states[began] = self._replayer.states_at(origins)
        return Front(states, Stays(graph.places[rows], lies(keys)), keys)

    def _nudged(self, rng: np.random.Generator, front: Front, chosen: Bools) -> Front:
        """The chosen characters [n] a little beside where they were: what only holds to the millimetre is no trap."""
        nudge = rng.uniform(-NUDGE_M, NUDGE_M, (len(chosen), 3))
        nudge[:, 2] = np.abs(nudge[:, 2])
        states = front.states.copy()
        states[chosen, :3] += nudge[chosen]
        return Front(states, front.stays, front.keys)

    def _back(self, trapped: Trapped, front: Front) -> Ints:
        """The headings [n] to the nearest place that leads back."""
        return heading_of(trapped.way_back(front.footings) - front.footings)

    # --- what is left -----------------------------------------------------------------------------

    def _done(self, trapped: Trapped, region: Region) -> bool:
        return len(self._tried(trapped, region)) >= ATTEMPTS + ATTEMPTS_A_PLACE * len(region.rows)

    def _tried(self, trapped: Trapped, region: Region) -> list[Attempt]:
        """The attempts that began in a region."""
        return self._attempts.of(trapped.graph.keys[region.rows])

    def _pocket(self, trapped: Trapped, region: Region, points: Points) -> Pocket:
        graph = trapped.graph
        attempts = self._tried(trapped, region)
        cells = np.unique(np.concatenate([attempt.cells for attempt in attempts]))
        inside = np.isin(self._transitions.cells(points.positions), graph.keys[region.core])
        arrival = int(self._known(trapped, region)[0])
        origin = Origin(*graph.origins[arrival].tolist())
        if (
            origin.step == origin.start and origin.parent >= 0
        ):  # it began there: see how that point was got to
            origin = points.origin(origin.parent)
        position = self._replayer.states_at([origin])[0, :3]
        return Pocket(
            cells=graph.places[region.core],  # not the rim that one only slides over
            points=np.flatnonzero(inside & points.grounded),
            arrival=Fall(origin, position, graph.places[arrival], np.full(3, np.nan)),
            stuck=region.stuck,
            attempts=len(attempts),
            sim_time_s=len(attempts) * self._level.explore.reset_interval * self._simulator.step_s,
            volume_m3=len(cells) * self._level.explore.threshold_m**3,
            reach_m=max(attempt.reach_m for attempt in attempts),
        )
