"""How likely each symbol of a coded mesh is: tables of training models to start from, then what has been seen."""

from __future__ import annotations

from meshmark.recovery.range_coder import Model

__all__ = ["GAP", "KNOWN", "LEADING", "LENGTHS", "NEW", "NOTHING", "RANKS", "SEED", "MeshModels"]

NOTHING, NEW, GAP, LEADING, KNOWN = range(5)
"""What lies beyond a gate: no face, one with a new corner, one that closes the gap to the border's next edge or to
the edge before, or one with another corner that is known."""
SEED = 3
"""The axis of the corners of a part's first face, whichever it is."""
RANKS = 7
"""Ranks of known corners that have a symbol of their own; the next symbol stands for all others."""
LENGTHS = 21
"""Numbers have fewer bits than this: an offset between places of 15 bits and a sign, in thirds."""
NO_GAP = 3
"""Class of a gap where the border does not go on."""
# Squared distance of a border point from the predicted corner, in edge lengths: up to which it is of class 0, 1.
NEAR = (0.25, 0.81)
# Faces at a point from which on it is likely to be closed.
MANY = 5
# Of 60, by the classes of the next point of the border and of the one before: what lies beyond a gate.
_KINDS = {
    (0, 0): (1, 8, 31, 18, 2), (0, 1): (1, 14, 39, 5, 1), (0, 2): (1, 19, 35, 1, 4), (0, 3): (12, 4, 41, 1, 4),
    (1, 0): (1, 10, 8, 39, 2), (1, 1): (1, 20, 25, 12, 1), (1, 2): (1, 29, 26, 2, 2), (1, 3): (7, 17, 27, 1, 8),
    (2, 0): (1, 16, 1, 41, 2), (2, 1): (1, 29, 2, 26, 2), (2, 2): (5, 35, 10, 6, 4), (2, 3): (31, 10, 6, 1, 13),
    (3, 0): (5, 26, 1, 18, 11), (3, 1): (26, 25, 1, 1, 9), (3, 2): (28, 16, 1, 4, 13), (3, 3): (51, 7, 1, 1, 2),
}  # fmt: skip
# Of 150, for each axis: how many bits a number has more than the length of the gate, from LEAST on. The last row is
# for the second and third corner of a part, more than the bits that the first one takes.
_LEAST = -8
_BITS = (
    (1, 1, 4, 13, 13, 14, 24, 33, 31, 10, 4, 2, 1),
    (1, 1, 6, 17, 21, 24, 28, 25, 15, 7, 3, 1, 1),
    (1, 1, 4, 11, 20, 28, 27, 24, 15, 9, 4, 3, 4),
    (4, 9, 14, 18, 20, 20, 18, 14, 9, 5, 2, 1, 1),
)
_HIGH, _SIGN, _RANK = (20, 16), (20, 20), (20, 8, 5, 4, 3, 2, 2, 8)
# Numbers are told apart by how many bits they have more than their gate's length, from and to this.
_FEWEST, _MOST = -4, 1
# How often a corner of a first face is one that is known; how often there is a further part.
_SEEN, _MORE = (16, 1), (1, 2)


class MeshModels:
    """The models of both sides; they learn alike."""

    def __init__(self) -> None:
        self.more, self.seen, self.rank = Model(_MORE), Model(_SEEN), Model(_RANK)
        self._kinds: dict[tuple[int, int, bool, bool], Model] = {}
        self._lengths: dict[tuple[int, int], Model] = {}
        self._high: dict[tuple[int, int], Model] = {}
        self._signs: dict[tuple[int, int], Model] = {}

    def kind(self, classes: tuple[int, int], faces: tuple[int, int]) -> Model:
        """Return the model of what lies beyond a gate.

        classes: of the next point of the border, and of the one before; faces: at the gate's end, and at its start.
        """
        key = (*classes, faces[0] >= MANY, faces[1] >= MANY)
        if key not in self._kinds:
            self._kinds[key] = Model(_KINDS[classes])
        return self._kinds[key]

    def length(self, axis: int, size: int) -> Model:
        """Return the model of the bits of a number beside a gate whose length has `size` bits."""
        if (axis, size) not in self._lengths:
            first = [1] * LENGTHS
            for place, count in enumerate(_BITS[axis], _LEAST + size):
                first[min(max(place, 0), LENGTHS - 1)] += count
            self._lengths[axis, size] = Model(first)
        return self._lengths[axis, size]

    def high(self, axis: int, more: int) -> Model:
        """Return the model of the second bit of a number that has `more` bits than its gate's length."""
        return _learnt(self._high, (axis, min(max(more, _FEWEST), _MOST)), _HIGH)

    def sign(self, axis: int, more: int) -> Model:
        """Return the model of the sign of such a number."""
        return _learnt(self._signs, (axis, min(max(more, _FEWEST), _MOST)), _SIGN)


def _learnt(models: dict[tuple[int, int], Model], key: tuple[int, int], first: tuple[int, ...]) -> Model:
    if key not in models:
        models[key] = Model(first)
    return models[key]
