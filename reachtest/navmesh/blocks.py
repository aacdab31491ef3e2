"""One block of a nav-mesh's grid, and what its islands share with the blocks beside it.

Shape legend: F triangles, Q patches, L labels of one island in one block.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.connected import part_labels
from reachtest.navmesh.contour import Patches, patches, some
from reachtest.navmesh.settings import BuildSettings
from reachtest.navmesh.voxels import Grid, rasterise
from reachtest.navmesh.walkable import Places, chosen, walkable_places
from reachtest.records import Floats, Ints


@dataclass(frozen=True)
class Block:
    """What one block brought; labels count from 0 in each block."""

    patches: Patches  # in cells of the whole grid
    area_m2: Floats  # [L]
    own: tuple[Ints, Ints]  # key and label of the places along the block's lower borders
    beyond: tuple[Ints, Ints]  # likewise of the first places of the next blocks


def build_block(
    triangles: Floats, settings: BuildSettings, grid: Grid, outer: Ints, begin: Ints, end: Ints
) -> Block | None:
    """Build the columns [begin, end) on a grid that starts at column `outer`; None where nothing is walkable."""
    spans = rasterise(triangles, settings.slope_deg, settings.agent.climb, grid, settings.both_sides)
    places = walkable_places(spans, grid.shape, settings.agent)
    place = outer + np.stack(np.divmod(places.column, grid.shape[1]), axis=1)
    # One row of the next blocks shows which of their islands go on here.
    keep = (place >= begin).all(axis=1) & (place <= end).all(axis=1) & (place < end).any(axis=1)
    places, place = chosen(places, keep), place[keep]
    inner = (place < end).all(axis=1)
    if not inner.any():
        return None
    next_to = places.neighbour[1:3]
    here = np.broadcast_to(np.arange(len(place)), next_to.shape)[next_to >= 0]
    label = part_labels(len(place), np.stack([here, next_to[next_to >= 0]], axis=1))
    area = np.bincount(label[inner], minlength=label.max() + 1).astype(np.float64) * settings.cell_m**2
    border = inner & (place == begin).any(axis=1)
    keys = _keys(place, places)
    core = chosen(places, inner)
    step = settings.cell_m * float(np.tan(np.radians(settings.slope_deg)))
    found = patches(core, spans.floor[core.span], label[inner], grid.shape[1], settings.cell_height_m, step)
    moved = Patches(found.corners + np.append(outer, 0.0), found.label)
    return Block(moved, area, (keys[border], label[border]), (keys[~inner], label[~inner]))


def _keys(place: Ints, places: Places) -> Ints:
    """One number for each place of the whole grid; two floors of one column never share it in practice: heights
    are taken modulo 65,536 cells."""
    return np.asarray((place[:, 0] << 40) | (place[:, 1] << 16) | (places.bottom & 0xFFFF), dtype=np.int64)


def large_islands(blocks: list[Block], settings: BuildSettings) -> Floats:
    """Corners [Q, 4, 3] of the patches whose island, over all blocks, is not too small."""
    starts = np.cumsum([0, *(len(block.area_m2) for block in blocks)])
    own, own_label = _joined([block.own for block in blocks], starts)
    beyond, label = _joined([block.beyond for block in blocks], starts)
    order = np.argsort(own)
    place = np.minimum(np.searchsorted(own[order], beyond), max(len(own) - 1, 0))
    same = own[order][place] == beyond if len(own) else np.zeros(len(beyond), dtype=np.bool_)
    pairs = np.stack([label[same], own_label[order][place[same]]], axis=1)
    island = part_labels(int(starts[-1]), pairs)
    area = np.bincount(island, weights=np.concatenate([block.area_m2 for block in blocks]))
    large = (area >= settings.min_island_m2)[island]
    kept = [
        some(block.patches, large[start + block.patches.label]).corners
        for block, start in zip(blocks, starts, strict=False)
    ]
    return np.concatenate(kept)


def _joined(parts: list[tuple[Ints, Ints]], starts: Ints) -> tuple[Ints, Ints]:
    """Keys, and labels that count over all blocks."""
    keys = np.concatenate([key for key, _ in parts])
    return keys, np.concatenate([label + start for (_, label), start in zip(parts, starts, strict=False)])
