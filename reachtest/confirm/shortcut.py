"""The nav-mesh knows short ways: from the start of a found way over the nav-mesh to where it left it for good.

Shape legend: V vertices of the nav-mesh, cut so that none are far apart.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from reachtest.confirm.pursuit import Route, route_of
from reachtest.confirm.trials import Trial
from reachtest.records import Floats, Ints, NavMesh

EDGE_M = 2.0  # as far apart as vertices may be: the ways are longer than the shortest by a twelfth at most
JOIN_M = 0.6  # vertices this near are joined: tiles share none, and a stair's steps lie apart by a climb
AROUND_M = 30.0  # of the nav-mesh around the way: a city's would take longer than the shorter way saves
MAX_AREA_M2 = 100_000.0


def over_navmesh(navmesh: NavMesh, trial: Trial, left: int) -> Route | None:
    """From the start of a trial over the nav-mesh to its place at step `left`, and on as found; None without a way."""
    tail = route_of(trial.positions[left], trial.positions[left + 1 :], trial.actions[left + 1 :])
    places = np.concatenate([trial.start[None, :3], trial.positions[: left + 1]])
    mesh = _nearby(navmesh.triangles, places)
    way = None if mesh is None else _shortest(*mesh, trial.start[:3], trial.positions[left])
    if way is None:
        return None
    points = np.concatenate([trial.start[None, :3], way, tail.points])
    jumps = np.concatenate([np.zeros(len(way) + 1, dtype=np.bool_), tail.jumps])
    return Route(points, jumps)


def _nearby(triangles: Floats, places: Floats) -> tuple[Floats, Ints] | None:
    """Vertices [V, 3] and edges [E, 2] of the nav-mesh around `places` [n, 3]; None if that is too much."""
    from trimesh.remesh import subdivide_to_size
    from trimesh.triangles import area

    low, high = places.min(axis=0)[:2] - AROUND_M, places.max(axis=0)[:2] + AROUND_M
    near = ((triangles.min(axis=1)[:, :2] <= high) & (triangles.max(axis=1)[:, :2] >= low)).all(axis=1)
    some = triangles[near]
    if not len(some) or area(some).sum() > MAX_AREA_M2:
        return None
    vertices, faces = subdivide_to_size(
        some.reshape(-1, 3), np.arange(3 * len(some)).reshape(-1, 3), EDGE_M, max_iter=20
    )
    inner = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    joined = cKDTree(vertices).query_pairs(JOIN_M, output_type="ndarray")
    return vertices, np.concatenate([inner, joined])


def _shortest(vertices: Floats, edges: Ints, start: Floats, end: Floats) -> Floats | None:
    """The places [n, 3] of the shortest way along the edges; None if there is none."""
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    count = len(vertices)
    graph = coo_matrix((length + 1e-6, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
    _, nearest = cKDTree(vertices).query(np.stack([start, end]))
    first, last = np.asarray(nearest).tolist()
    _, paths = dijkstra(graph, directed=False, indices=np.array([first]), return_predecessors=True)
    before = paths[0]
    way = [last]
    while way[-1] != first:
        if before[way[-1]] < 0:
            return None
        way.append(int(before[way[-1]]))
    return np.asarray(vertices[way[::-1]], dtype=np.float64)
