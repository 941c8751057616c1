"""Which lattice of a key a model has: a label made of its shape, found again from the shape alone.

A fixed linear map takes the invariants of a shape to a few coordinates in which attacks move it little and other
models lie far away. They fall into bins of width 1, shifted by the key; the label is a keyed hash of these. An
attack may push a coordinate over the nearest edge of its bin: the reader tries the likeliest few labels (decision
0020).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import blake2b
from importlib import resources
from math import inf
from typing import Any, Final

import numpy as np

from meshmark.coding.keyed import keyed_words, unit_interval
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.invariants import INVARIANTS
from meshmark.mesh import FloatArray, IntArray

__all__ = ["LABEL_BYTES", "Label", "LabelMap", "dump_map", "labels", "parse_map", "shipped_map"]

LABEL_BYTES: Final = 16
KIND: Final = "meshmark label map 1"
_FILE: Final = "label_map.json"
_PERSON: Final = b"meshmark label 1"
# Coordinates are rounded to this share of a bin: sums that differ in their last bits give the same prices.
ROUNDING: Final = 2.0**-24


@dataclass(frozen=True)
class Label:
    """The name of one of the lattices of a key: 16 pseudo-random bytes, of which nothing of the shape follows.

    Raises `InputError` for any other number of bytes.
    """

    digest: bytes

    def __post_init__(self) -> None:
        """Check the length."""
        if len(self.digest) != LABEL_BYTES:
            raise InputError(f"a lattice label of {len(self.digest)} bytes, expected {LABEL_BYTES}")

    @classmethod
    def of_bins(cls, key: Key, bins: IntArray) -> Label:
        """Return the label of bins (c,), which are whole numbers of 64 bits."""
        data = np.ascontiguousarray(bins, dtype="<i8").tobytes()
        subkey = key.subkey("lattice label")
        return cls(blake2b(data, digest_size=LABEL_BYTES, key=subkey, person=_PERSON).digest())

    @classmethod
    def of_hex(cls, text: str) -> Label:
        """Return the label that `str` writes so."""
        return cls(bytes.fromhex(text))

    @classmethod
    def of_shape(cls, invariants: FloatArray, key: Key) -> Label:
        """Return the label of a shape as it stands, which its mark takes."""
        return labels(invariants, key, most=1)[0]

    def __str__(self) -> str:
        return self.digest.hex()


@dataclass(frozen=True, eq=False)
class LabelMap:
    """What takes invariants to coordinates in bins: matrix (len(INVARIANTS), c)."""

    matrix: FloatArray

    def __post_init__(self) -> None:
        """Check the shape."""
        if self.matrix.ndim != 2 or len(self.matrix) != len(INVARIANTS):
            raise InputError(
                f"a label map of shape {self.matrix.shape}, expected a row for each of {len(INVARIANTS)} invariants"
            )

    @property
    def components(self) -> int:
        """The number of coordinates, c."""
        return int(self.matrix.shape[1])


def labels(
    invariants: FloatArray,
    key: Key,
    most: int = 4,
    label_map: LabelMap | None = None,
    *,
    dearest: float = inf,
) -> tuple[Label, ...]:
    """Return the labels that a shape most likely had before it was damaged, likeliest first.

    The first is that of the shape as it stands. Others take some coordinates over the nearer edge of their bin; the
    price of that is the sum of the squared distances to these edges, and the cheapest come first. Equal prices are
    ordered by which coordinates change, the first coordinate last.

    Parameters
    ----------
    invariants : (16,) float array
        As `shape_invariants` returns them.
    key : Key
        Shifts the bins, and keys the hash.
    most : int
        How many labels, at least 1; there are no more than 2^c.
    label_map : LabelMap, optional
        The shipped one by default.
    dearest : float
        The highest price, in squared widths of a bin, of a label but the first.

    Returns
    -------
    tuple of Label
        At most `most` different labels, at least one.

    Raises
    ------
    InputError
        `most` is below 1, or the invariants are of another number or not finite.
    """
    if most < 1:
        raise InputError(f"{most} labels asked for, expected at least 1")
    if invariants.shape != (len(INVARIANTS),) or not np.isfinite(invariants).all():
        raise InputError(f"invariants of shape {invariants.shape}, expected {len(INVARIANTS)} finite numbers")
    used = shipped_map() if label_map is None else label_map
    count = used.components
    shift = unit_interval(keyed_words(key.subkey("lattice label bins"), count))
    place = np.round((invariants @ used.matrix + shift) / ROUNDING) * ROUNDING
    bins = np.floor(place)
    within = place - bins
    beyond = np.where(within < 0.5, -1.0, 1.0)
    price = np.minimum(within, 1.0 - within) ** 2
    changed = (np.arange(2**count)[:, None] >> np.arange(count)[::-1]) & 1
    prices = changed @ price
    order = np.argsort(prices, kind="stable")[:most]
    order = order[prices[order] <= max(dearest, 0.0)]
    return tuple(
        Label.of_bins(key, (bins + row * beyond).astype(np.int64)) for row in changed[order].astype(float)
    )


def dump_map(label_map: LabelMap, notes: Mapping[str, Any]) -> str:
    """Return a map as JSON text, its numbers to the last bit; notes: how it was made."""
    fields = {"kind": KIND, **notes, "components": label_map.components}
    lines = [f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in fields.items()]
    rows = zip(INVARIANTS, label_map.matrix.tolist(), strict=True)
    table = ",\n".join(f"    {json.dumps(name)}: {json.dumps(row)}" for name, row in rows)
    return "{\n" + ",\n".join([*lines, '  "matrix": {\n' + table + "\n  }"]) + "\n}\n"


def parse_map(text: str) -> LabelMap:
    """Return the map of a JSON text; raises `InputError` unless it is one and takes these invariants."""
    try:
        fields = json.loads(text)
        if fields["kind"] != KIND:
            raise InputError(f"the label map is of kind '{fields['kind']}', expected '{KIND}'")
        named = fields["matrix"]
        matrix = np.array(list(named.values()), dtype=np.float64)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"the text is not a label map: {error!r}") from error
    if tuple(named) != INVARIANTS:
        raise InputError(f"the label map takes {', '.join(named)}, expected {', '.join(INVARIANTS)}")
    return LabelMap(matrix)


@cache
def shipped_map() -> LabelMap:
    """Return the map that this version uses: another one would not find the labels of earlier marks."""
    return parse_map(resources.files("meshmark.ownership.carriers").joinpath(_FILE).read_text("utf-8"))
