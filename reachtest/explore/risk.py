"""The risk that remains: what a run knew of it at each moment, and whether that is enough to stop."""

from __future__ import annotations

from collections import deque

from reachtest.explore.visits import VisitCounts
from reachtest.records import Bools, GateSettings, Ints, RiskSample

MOST_SAMPLES = 50  # of a curve: as many as a chart or a table has use for
# Which episodes are the latest ones: a fifth of all, because the share that finds something new falls as a power of
# their number, so that a fifth lags little behind; at least 100, or the share is noise; at most 5,000, which tell 1 %
# from 1.5 %.
RECENT, RECENT_LEAST, RECENT_MOST = 0.2, 100, 5_000


class RiskCurve:
    """Samples evenly over the rounds: when there are too many, every other one is dropped.

    What is kept depends on the number of rounds only, so that memory is bounded and the curve reproducible.
    """

    def __init__(self) -> None:
        self._every, self._rounds = 1, 0
        self._kept: list[RiskSample] = []
        self._recent: deque[tuple[int, int]] = deque()  # a round's episodes, and how many found a new cell
        self._episodes = self._discovering = 0  # of these
        self.latest = RiskSample(*[0] * 10)

    @property
    def samples(self) -> tuple[RiskSample, ...]:
        """At most MOST_SAMPLES of them; the last is the run's latest round."""
        off_beat = self._rounds % self._every
        return (*self._kept, self.latest) if off_beat else tuple(self._kept)

    def note(
        self, discovering: int, visits: VisitCounts, steps: int, episodes: int, goals: int, points: int
    ) -> None:
        """One more round, in which `discovering` episodes found a new cell; the rest counts from the beginning."""
        self._note_recent(episodes - self.latest.episodes, discovering)
        recent = (self._episodes, self._discovering)
        total = self.latest.discovering + discovering
        self.latest = RiskSample(steps, episodes, total, *visits.incidence(), *recent, goals, points)
        self._rounds += 1
        if self._rounds % self._every == 0:
            self._kept.append(self.latest)
        if len(self._kept) >= MOST_SAMPLES:  # the latest one may come on top
            self._kept = self._kept[1::2]
            self._every *= 2

    def _note_recent(self, episodes: int, discovering: int) -> None:
        """Keep the fewest latest rounds that have enough episodes together."""
        self._recent.append((episodes, discovering))
        self._episodes += episodes
        self._discovering += discovering
        enough = min(max(RECENT * (self.latest.episodes + episodes), RECENT_LEAST), RECENT_MOST)
        while self._episodes - self._recent[0][0] >= enough:
            fewer, found = self._recent.popleft()
            self._episodes -= fewer
            self._discovering -= found


def is_done(gate: GateSettings, reached_step: Ints, wanted: Bools, latest: RiskSample) -> bool:
    """Whether all `wanted` goals [G] are reached (-1: not) and the risk is within the limit, where one is set."""
    limit = gate.max_discovery_probability
    if limit is None or (reached_step[wanted] < 0).any():
        return False
    return latest.risk <= limit
