"""Which faces of a nav-mesh are neighbours: those that share an edge, and those that lie against each other.

Shape legend: F faces, E boundary edges, N pairs. Detour tiles and other exports share no vertices across their
borders: there are T-junctions, gaps of a few centimetres, and steps of up to the agent's climb.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from reachtest.geometry import expand
from reachtest.navmesh.faces import FaceIndex
from reachtest.records import Floats, Ints, NavMesh

SAME_M = 1e-3  # vertices of one edge, as two polygons state it in float32
GAP_M = 0.1  # between borders that belong together; erosion keeps the two sides of a wall farther apart
_BEYOND_GAP_M = 1.5 * GAP_M  # out there another face would have begun
OVERLAP_M = 0.05  # of two borders: less is a touch at a corner
PARALLEL = 0.966  # cosine of 15 degrees: borders that merely meet at a corner run apart sooner
_PIECE_M = 0.5  # edges are looked up in pieces of this length: near pieces, few pairs
_MOST_PIECES = 2_000_000
_PAIRS_AT_ONCE = 1 << 20  # bounds the memory of one vectorised pass to about 100 MB


def neighbours(navmesh: NavMesh, climb_m: float) -> Ints:
    """Pairs of faces [N, 2] one can walk between, each at least once, in either order.

    Borders of different faces lie against each other where they run along each other within `GAP_M`
    horizontally and `climb_m` vertically for more than `OVERLAP_M`. A border may also run over a face.
    """
    shared, ends, owner = _edges(navmesh)
    pairs = _touching(ends, owner, climb_m)
    open_ = np.ones(len(ends), dtype=np.bool_)
    open_[pairs] = False
    onto = _landing(navmesh, ends[open_], owner[open_], climb_m)
    return np.concatenate([shared, owner[pairs], onto])


def border(navmesh: NavMesh, piece_m: float, climb_m: float) -> tuple[Floats, Floats, Ints]:
    """The border in pieces of at most `piece_m`: where the surface ends and no other face goes on beside it.

    Returns their middles [n, 3], unit vectors straight outwards [n, 2], and the faces that end there [n].
    """
    _, ends, owner = _edges(navmesh)
    middles, edge = _cut(ends, piece_m)
    outwards = _outwards(navmesh, ends, owner)[edge]
    beside = middles.copy()
    beside[:, :2] += _BEYOND_GAP_M * outwards
    beneath, _ = FaceIndex(navmesh.triangles, 0.0).below(beside, climb_m, climb_m)
    ends_here = (beneath < 0) & outwards.any(axis=1)
    return middles[ends_here], outwards[ends_here], owner[edge[ends_here]]


def _edges(navmesh: NavMesh) -> tuple[Ints, Floats, Ints]:
    """Pairs of faces [N, 2] that share an edge; and the edges of one face only: ends [E, 2, 3] and the face [E]."""
    corner = _weld(navmesh.vertices)[navmesh.faces]  # [F, 3]
    edge = np.sort(np.stack([corner, np.roll(corner, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(navmesh.faces)), 3)
    order = np.lexsort((edge[:, 1], edge[:, 0]))
    same = (edge[order[1:]] == edge[order[:-1]]).all(axis=1)
    shared = np.stack([face[order[:-1]][same], face[order[1:]][same]], axis=1)
    alone = np.ones(len(edge), dtype=np.bool_)
    alone[order[:-1][same]] = alone[order[1:][same]] = False
    single = np.flatnonzero(alone & (edge[:, 0] != edge[:, 1]))
    ends = np.stack([navmesh.triangles, np.roll(navmesh.triangles, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return shared, ends[single], face[single]


def _outwards(navmesh: NavMesh, ends: Floats, owner: Ints) -> Floats:
    """Horizontal unit vectors [E, 2] away from the owners of edges [E, 2, 3]; zero for an upright edge."""
    along = (ends[:, 1] - ends[:, 0])[:, :2]
    aside = np.stack([along[:, 1], -along[:, 0]], axis=1)
    aside /= np.maximum(np.linalg.norm(aside, axis=1), SAME_M)[:, None]
    inwards = ((navmesh.triangles[owner].mean(axis=1) - ends.mean(axis=1))[:, :2] * aside).sum(axis=1)
    return np.where(inwards > 0, -1.0, 1.0)[:, None] * aside


def _landing(navmesh: NavMesh, ends: Floats, owner: Ints, climb_m: float) -> Ints:
    """Pairs of faces [N, 2]: the owner of an edge [E, 2, 3] that runs over another face, and that face.

    As the foot of a ramp that somebody laid onto a floor without cutting it.
    """
    middle = ends.mean(axis=1)
    middle[:, :2] += GAP_M / 2 * _outwards(navmesh, ends, owner)
    beneath, _ = FaceIndex(navmesh.triangles, 0.0).below(middle, climb_m, climb_m)
    found = (beneath >= 0) & (beneath != owner)
    return np.stack([owner[found], beneath[found]], axis=1)


def _weld(vertices: Floats) -> Ints:
    """One number [V] for all vertices at the same place (on a grid: a few that differ by less are missed)."""
    cell = np.rint(vertices / SAME_M).astype(np.int64)
    order = np.lexsort(cell.T)
    new = np.append(True, (cell[order[1:]] != cell[order[:-1]]).any(axis=1))[: len(cell)]
    result = np.empty(len(cell), dtype=np.int64)
    result[order] = np.cumsum(new) - 1
    return result


def _touching(ends: Floats, face: Ints, climb_m: float) -> Ints:
    """Pairs of edges [N, 2] of different faces that lie against each other, of edges [E, 2, 3]."""
    pairs = _near_pairs(ends, climb_m)
    pairs = pairs[face[pairs[:, 0]] != face[pairs[:, 1]]]
    kept = [
        some[_against(ends[some[:, 0]], ends[some[:, 1]], climb_m)]
        for begin in range(0, len(pairs), _PAIRS_AT_ONCE)
        for some in (pairs[begin : begin + _PAIRS_AT_ONCE],)
    ]
    return np.concatenate([np.empty((0, 2), dtype=np.int64), *kept])


def _near_pairs(ends: Floats, climb_m: float) -> Ints:
    """Pairs of edges [N, 2] with a piece each whose middles are near enough for the edges to touch."""
    if not len(ends):
        return np.empty((0, 2), dtype=np.int64)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    piece_m = max(_PIECE_M, float(length.sum()) / _MOST_PIECES)
    middles, edge = _cut(ends, piece_m)
    reach = piece_m + float(np.hypot(GAP_M, climb_m))
    found = cKDTree(middles).query_pairs(reach, output_type="ndarray")
    pairs = np.sort(edge[found], axis=1)
    packed = np.sort(pairs[:, 0] * len(ends) + pairs[:, 1])
    packed = packed[np.append(True, packed[1:] != packed[:-1])[: len(packed)]]  # faster than np.unique
    return np.stack([packed // len(ends), packed % len(ends)], axis=1)


def _cut(ends: Floats, piece_m: float) -> tuple[Floats, Ints]:
    """Edges [E, 2, 3] in pieces of at most `piece_m`: their middles [n, 3], and the edge of each [n]."""
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    count = np.maximum(np.ceil(length / piece_m), 1).astype(np.int64)
    edge, place = expand(count)
    share = ((place + 0.5) / count[edge])[:, None]
    return ends[edge, 0] * (1 - share) + ends[edge, 1] * share, edge


def _against(first: Floats, second: Floats, climb_m: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of the edges `first` [N, 2, 3] run along their `second` [N, 2, 3].

    Along the first edge, the second's sideways distance and its height above are linear: what is left of the
    interval where both are small enough has to be long enough.
    """
    along = first[:, 1, :2] - first[:, 0, :2]
    length = np.linalg.norm(along, axis=1)
    unit = along / np.maximum(length, SAME_M)[:, None]
    away = second[:, :, :2] - first[:, None, 0, :2]  # [N, 2, 2]
    s = np.einsum("nij,nj->ni", away, unit)  # where the second's ends are along the first
    side = away[:, :, 1] * unit[:, None, 0] - away[:, :, 0] * unit[:, None, 1]
    shorter = np.minimum(length, np.hypot(*(second[:, 1, :2] - second[:, 0, :2]).T))
    run = s[:, 1] - s[:, 0]
    parallel = np.abs(run) >= PARALLEL * np.hypot(run, side[:, 1] - side[:, 0])
    safe = np.where(np.abs(run) > 1e-9, run, 1.0)
    slope = (first[:, 1, 2] - first[:, 0, 2]) / np.maximum(length, SAME_M)
    rise = second[:, :, 2] - first[:, None, 0, 2] - slope[:, None] * s
    low, high = np.maximum(s.min(axis=1), 0.0), np.minimum(s.max(axis=1), length)
    for value, limit in ((side, GAP_M), (rise, climb_m)):
        change = (value[:, 1] - value[:, 0]) / safe
        start = value[:, 0] - change * s[:, 0]  # the value at s = 0
        flat = np.abs(change) < 1e-12
        steep = np.where(flat, 1.0, change)
        one, two = (-limit - start) / steep, (limit - start) / steep
        low = np.maximum(
            low, np.where(flat, np.where(np.abs(start) <= limit, low, np.inf), np.minimum(one, two))
        )
        high = np.minimum(high, np.where(flat, high, np.maximum(one, two)))
    return np.asarray(parallel & (high - low > np.minimum(OVERLAP_M, shorter / 2)))
