"""Between which places the episodes went: footings only, a flight is one transition, a fall leads out."""

from __future__ import annotations

import numpy as np

from reachtest.explore.graph import OUT, Graph, lies
from reachtest.explore.retrace import Retrace
from reachtest.explore.rollout import Trajectories
from reachtest.explore.stays import Stays
from reachtest.explore.transitions import Transitions
from reachtest.records import EndReason


def rolled(*episodes) -> Trajectories:
    """Lanes of (place, stands) or "fell", a step each; every lane is one episode."""
    steps, lanes = len(episodes[0]), len(episodes)
    positions, stood = np.full((2, steps, lanes, 3), np.nan)
    ended = np.zeros((steps, lanes), dtype=np.int8)
    start = np.zeros((steps, lanes), dtype=np.int16)
    for lane, episode in enumerate(episodes):
        for t, step in enumerate(episode):
            if step == "fell":
                ended[t, lane] = EndReason.FELL
                start[t + 1 :, lane] = t + 1
                continue
            place, stands = step
            positions[t, lane] = place
            stood[t, lane] = place if stands else np.nan
    none = np.zeros((steps, lanes), dtype=np.int16)
    states = np.zeros((steps, lanes, 7))
    return Trajectories(positions, states, np.isfinite(stood[:, :, 0]), stood, start, none, ended, positions)


def graph_of(*rounds) -> tuple[Graph, Transitions]:
    """Rounds of (trajectories, footings [B, 3])."""
    transitions = Transitions(1.0, 7)
    for number, (round_, footings) in enumerate(rounds):
        parents = np.full((1, len(footings)), -1)
        stays = Stays(np.array([footings], dtype=float), np.zeros((1, len(footings)), dtype=bool))
        transitions.add(round_, stays, parents, number)
    return transitions.graph(), transitions


def row(transitions: Transitions, graph: Graph, place) -> int:
    return int(np.searchsorted(graph.keys, transitions.cells(np.array([place], dtype=float))[0]))


def test_a_jump_over_a_pit_does_not_lead_into_it() -> None:
    near, pit, far = [0.5, 0.5, 0.0], [2.5, 0.5, -3.0], [5.5, 0.5, 0.0]
    jump = rolled([([1.5, 0.5, 0.5], False), ([2.5, 0.5, 0.8], False), (far, True)])
    fall = rolled([([2.5, 0.5, -1.0], False), (pit, True), (pit, True)])
    graph, transitions = graph_of((jump, [near]), (fall, [near]))
    a, b, c = (row(transitions, graph, place) for place in (near, pit, far))
    assert {tuple(ends) for ends in graph.ends.tolist()} == {(a, b), (a, c)}
    reach = np.zeros(len(graph.keys), dtype=bool)
    reach[a] = True
    assert graph.leads_to(reach).nonzero()[0].tolist() == [a]
    assert set(graph.led_to_from(reach).nonzero()[0].tolist()) == {a, b, c}


def test_who_falls_out_of_the_world_goes_out_and_the_next_episode_starts_where_it_starts() -> None:
    edge, home = [0.5, 0.5, 0.0], [9.5, 0.5, 0.0]
    round_ = rolled([([1.5, 0.5, -3.0], False), "fell", ([8.5, 0.5, 0.0], True)])
    round_.which[2] = 1
    transitions = Transitions(1.0, 7)
    starts = Stays(np.array([[edge], [home]], dtype=float), np.zeros((2, 1), dtype=bool))
    transitions.add(round_, starts, np.array([[-1], [-2]]), 4)
    graph = transitions.graph()
    a, b, c = (row(transitions, graph, place) for place in (edge, home, [8.5, 0.5, 0.0]))
    assert {tuple(ends) for ends in graph.ends.tolist()} == {(a, 0), (b, c)}
    assert graph.keys[0] == OUT
    assert graph.origins[c].tolist() == [-2, 4, 0, 2, 3]


def test_a_place_to_lie_still_in_is_a_place_and_the_top_of_a_jump_is_none() -> None:
    wedge, top = [3.5, 0.5, -2.0], [0.5, 3.5, 0.9]
    still = rolled(
        [(wedge, False)] * 4, [([0.5, 3.5, 0.5], False), (top, False), (top, False), ([0.5, 3.5, 0.4], False)]
    )
    graph, _ = graph_of((still, [[0.5, 0.5, 0.0], [0.5, 3.5, 0.0]]))
    found = {tuple(np.round(place, 3)) for place in graph.places[1:].tolist()}
    assert tuple(wedge) in found
    assert tuple(top) not in found


def test_who_stands_beside_a_wedge_gets_away_and_who_lies_in_it_does_not() -> None:
    rim, floor, wedge = [0.5, 0.5, 0.0], [3.2, 0.5, -2.0], [3.6, 0.5, -2.1]
    round_ = rolled([(floor, True), (rim, True), (rim, True)], [(wedge, False)] * 3)
    graph, transitions = graph_of((round_, [rim, rim]))
    lying = lies(graph.keys)
    assert lying.sum() == 1
    assert graph.keys[lying] == transitions.cells(np.array([wedge]), True)
    home = np.arange(len(graph.keys)) == row(transitions, graph, rim)
    assert graph.leads_to(home).tolist() == (~lying & ~graph.is_out).tolist()

    starts = Stays(np.array([[wedge]]), np.ones((1, 1), dtype=bool))
    transitions.add(rolled([(floor, True)]), starts)  # somebody got out of it after all
    assert transitions.graph().leads_to(home).sum() == 3


def test_rounds_add_up_and_the_first_way_to_a_place_is_kept() -> None:
    places = [[x + 0.5, 0.5, 0.0] for x in range(30)]
    rounds = [(rolled([(places[i + 1], True)]), [places[i]]) for i in range(29)]
    graph, transitions = graph_of(*rounds, *rounds)
    assert len(graph.keys) == 31
    assert len(graph.ends) == 29
    assert graph.origins[row(transitions, graph, places[7])].tolist() == [-1, 6, 0, 0, 1]
    assert transitions.nbytes < 150 * len(graph.keys)  # 56 of them the state


def test_a_place_is_kept_in_its_own_cell() -> None:
    """Rounded, one at the border of two cells was in the other: who began there was never seen to leave (1 of 40 runs
    of maps/small called it stuck)."""
    place = [-23.0 - 1e-9, 5.0 - 1e-12, 0.0]
    graph, transitions = graph_of((rolled([(place, True), ([-20.5, 5.5, 0.0], True)]), [[-25.5, 5.5, 0.0]]))
    assert row(transitions, graph, place) == row(transitions, graph, np.float32(place))
    np.testing.assert_array_equal(transitions.cells(graph.places[1:]), graph.keys[1:])


def steps_on_the_ground(*steps, speed: float = 6.0, standing: bool = True) -> set[tuple[int, int]]:
    """The transitions of one episode over places 1, 2, ... m along x, of (height, stands) each, from (0, 0)."""
    walk = rolled([([1.5 + t, 0.5, height], stands) for t, (height, stands) in enumerate(steps)])
    walk.states[:, :, 3] = speed
    transitions = Transitions(1.0, 7, Retrace(drop_m=0.05, speed_mps=3.0))
    starts = Stays(np.array([[[0.5, 0.5, 0.0]]]), np.zeros((1, 1), dtype=bool))
    transitions.add(walk, starts, np.zeros((1, 1), dtype=int), 0, np.full((1, 1), standing))
    graph = transitions.graph()
    across = np.round(graph.places[:, 0] - 0.5)
    return {(int(across[a]), int(across[b])) for a, b in graph.ends.tolist()}


def test_what_was_walked_through_on_level_ground_leads_back() -> None:
    assert steps_on_the_ground((0, True), (0, True)) == {(0, 1), (1, 0), (1, 2)}


def test_a_step_up_leads_back_down_and_a_step_down_not_back_up() -> None:
    up = steps_on_the_ground((0.3, True), (0.3, True))
    down = steps_on_the_ground((0, True), (-0.3, True), (-0.3, True))
    assert up == {(0, 1), (1, 0), (1, 2)}
    assert down == {(0, 1), (1, 2), (2, 3)}


def test_a_flight_does_not_lead_back() -> None:
    assert steps_on_the_ground((0.6, False), (0, True), (0, True)) == {(0, 2), (2, 3)}
    assert steps_on_the_ground((0, True), (0, True), standing=False) == {(0, 1), (1, 2)}


def test_who_was_stopped_may_be_held_there() -> None:
    assert steps_on_the_ground((0, True), (0, True), speed=2.0) == {(0, 1), (1, 2)}


def test_one_episode_is_not_walked_on_from_in_the_next() -> None:
    assert steps_on_the_ground((0, True)) == {(0, 1)}
    two = rolled([([1.5, 0.5, 0], True)], [([1.5, 0.5, 0], True)])
    two.states[:, :, 3] = 6.0
    transitions = Transitions(1.0, 7, Retrace(drop_m=0.05, speed_mps=3.0))
    starts = Stays(np.array([[[0.5, 0.5, 0.0], [0.5, 0.5, 0.0]]]), np.zeros((1, 2), dtype=bool))
    transitions.add(two, starts, np.zeros((1, 2), dtype=int), 0, np.ones((1, 2), dtype=bool))
    assert len(transitions.graph().ends) == 1
