"""Buildings: rooms at different heights with doors, stairs, ramps and crates."""

from __future__ import annotations

import numpy as np
import trimesh
from shapes import box, walls

THICK_M, SLAB_M, WALL_M = 0.4, 0.6, 3.5
DOOR_M, TREAD_M, STEP_M, RAMP_DEG = 1.8, 0.35, 0.3, 30.0


def make(rng: np.random.Generator) -> tuple[list[trimesh.Trimesh], np.ndarray]:
    """The pieces of a building, and a place in it to start from [3]."""
    building = Building(rng)
    return building.pieces, building.spawn()


class Building:
    """The pieces of one building, axis-aligned, z up, in metres."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.pieces = rng, list[trimesh.Trimesh]()
        self.size = rng.integers(3, 6, 2)
        self.room_m = float(rng.uniform(6, 10))
        self.floor = np.round(rng.integers(0, 4, self.size) * rng.choice([0.9, 1.2, 1.5]), 2)
        self.top, self.bottom = self.floor.max() + WALL_M, self.floor.min() - SLAB_M
        for room in np.ndindex(*self.size):
            self._room(np.array(room))
        for here, there, opens in self._borders():
            self._border(here, there, opens)
        x, y = self.size * self.room_m
        self.pieces += walls((x, y), THICK_M / 2, self.bottom, self.top)

    def box(self, low: object, high: object) -> None:
        """Add a box."""
        self.pieces.append(box(low, high))

    def spawn(self) -> np.ndarray:
        """A place on a floor with nothing in the way."""
        for room in np.ndindex(*self.size):
            at = np.append(np.array(room) * self.room_m + [1.2, self.room_m / 2], self.floor[room] + 0.05)
            low, high = at + [-0.6, -0.6, 0.05], at + [0.6, 0.6, 2.0]
            if not any((p.bounds[0] < high).all() and (p.bounds[1] > low).all() for p in self.pieces):
                return at
        raise ValueError("no room has a free place")

    def _room(self, room: np.ndarray) -> None:
        low, z = room * self.room_m, self.floor[tuple(room)]
        self.box([*low, z - SLAB_M], [*(low + self.room_m), z])
        for _ in range(int(self.rng.integers(0, 4))):
            corner, size = low + self.rng.uniform(1.8, self.room_m - 3.4, 2), self.rng.uniform(0.6, 1.6, 2)
            self.box([*corner, z], [*(corner + size), z + self.rng.choice([0.3, 0.7, 1.0, 1.3])])

    def _borders(self) -> list[tuple[np.ndarray, np.ndarray, bool]]:
        """Rooms side by side, and whether a door is between: enough of them to get everywhere."""
        rooms = [np.array(room) for room in np.ndindex(*self.size)]
        pairs = [(a, a + step) for step in ([1, 0], [0, 1]) for a in rooms if (a + step < self.size).all()]
        group = {tuple(room): number for number, room in enumerate(rooms)}
        result = []
        for number in self.rng.permutation(len(pairs)):
            a, b = pairs[number]
            one, other = group[tuple(a)], group[tuple(b)]
            result.append((a, b, one != other or self.rng.random() < 0.25))
            group = {room: one if own == other else own for room, own in group.items()}
        return result

    def _border(self, here: np.ndarray, there: np.ndarray, opens: bool) -> None:
        axis = int(np.argmax(there - here))
        at, start = there[axis] * self.room_m, here[1 - axis] * self.room_m
        low, high = sorted((self.floor[tuple(here)], self.floor[tuple(there)]))

        def slab(span: tuple[float, float], side: tuple[float, float], z: tuple[float, float]) -> None:
            ends = [[s, u] if axis == 0 else [u, s] for s, u in zip(side, span, strict=True)]
            self.box([*ends[0], z[0]], [*ends[1], z[1]])

        wall, end = (at - THICK_M / 2, at + THICK_M / 2), start + self.room_m
        if not opens:
            slab((start, end), wall, (low - SLAB_M, self.top))
            return
        door = start + float(self.rng.choice([0.6, self.room_m - 0.6 - DOOR_M]))
        slab((start, door), wall, (low - SLAB_M, self.top))
        slab((door + DOOR_M, end), wall, (low - SLAB_M, self.top))
        slab((door, door + DOOR_M), wall, (low - SLAB_M, high))  # the sill
        away = -1.0 if self.floor[tuple(here)] < self.floor[tuple(there)] else 1.0
        steps, stairs = int(np.ceil((high - low) / STEP_M)), self.rng.random() < 0.5
        tread = TREAD_M if stairs else (high - low) / max(steps, 1) / np.tan(np.radians(RAMP_DEG)) / 8
        for k in range(1, steps if stairs else 8 * steps):  # a ramp is stairs of 4 cm or less
            z = high - (high - low) * k / (steps if stairs else 8 * steps)
            side = sorted(at + away * (THICK_M / 2 + tread * np.array([k - 1, k])))
            slab((door, door + DOOR_M), (side[0], side[1]), (low - 0.3, z))
