"""Every distinct place in a glTF's buffers where a position is stored: reading and writing them.

Two accessors may share some or all of their bytes. A *slot* is one address with one position; a shared
position is one slot, so that whatever moves it moves it for all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError, InputError
from meshmark.io.gltf.accessor import Accessor, normalised
from meshmark.io.gltf.container import Bytes
from meshmark.mesh import FloatArray, IntArray

__all__ = ["Kind", "Points", "open_points"]


@dataclass(frozen=True)
class Kind:
    """How a component is stored."""

    dtype: np.dtype[Any]
    normalized: bool

    def encode(self, values: FloatArray) -> NDArray[Any]:
        """Return the stored form nearest to values; integers saturate at the ends of their range."""
        if self.dtype.kind == "f":
            with np.errstate(over="ignore"):
                return values.astype(self.dtype)
        limits = np.iinfo(self.dtype)
        low = -limits.max if self.normalized and limits.min < 0 else limits.min
        scaled = values * limits.max if self.normalized else values
        return np.clip(np.rint(scaled), low, limits.max).astype(self.dtype)


@dataclass(frozen=True, eq=False, kw_only=True)
class Points:
    """All slots. address (s,), -1 where a position has no bytes; values (s, 3); groups of equal kind."""

    address: IntArray
    values: FloatArray
    groups: tuple[tuple[Kind, IntArray], ...]
    slots: dict[int, IntArray]

    def snapped(self, values: FloatArray, moved: NDArray[np.bool_]) -> FloatArray:
        """Return what the slots hold after `values` (s, 3) were stored in those that moved."""
        return self._stored(values, moved, None)

    def written(self, values: FloatArray, moved: NDArray[np.bool_], blob: Bytes) -> Bytes:
        """Return the blob with `values` (s, 3) stored in the slots that moved."""
        changed = blob.copy()
        self._stored(values, moved, changed)
        return changed

    def _stored(self, values: FloatArray, moved: NDArray[np.bool_], blob: Bytes | None) -> FloatArray:
        if (moved & (self.address < 0)).any():
            raise InputError(
                "a position to be moved is an implied zero of an accessor without a bufferView: export the "
                "model with plain accessors first"
            )
        result = self.values.copy()
        for kind, members in self.groups:
            chosen = members[moved[members]]
            raw = kind.encode(values[chosen])
            result[chosen] = normalised(raw, kind.normalized)
            if blob is not None:
                _words(blob, kind.dtype)[_word_rows(self.address[chosen], kind.dtype)] = raw
        if not np.isfinite(result).all():
            raise InputError("a new position is beyond the range of the file's 32-bit floating point numbers")
        return result


def _words(blob: Bytes, dtype: np.dtype[Any]) -> NDArray[Any]:
    return blob[: len(blob) // dtype.itemsize * dtype.itemsize].view(dtype)


def _word_rows(address: IntArray, dtype: np.dtype[Any]) -> IntArray:
    return address[:, None] // dtype.itemsize + np.arange(3)


def open_points(blob: Bytes, accessors: Sequence[Accessor]) -> Points:
    """Gather the slots of POSITION accessors. Raises `FormatError` where they contradict each other."""
    rows = np.concatenate([item.addresses() for item in accessors])
    kinds = list(dict.fromkeys(Kind(item.dtype, item.normalized) for item in accessors))
    code = np.repeat(
        [kinds.index(Kind(item.dtype, item.normalized)) for item in accessors],
        [item.count for item in accessors],
    )
    if (np.diff(rows) > 0).all():
        address, first, slot = rows, np.arange(len(rows)), np.arange(len(rows))
    else:
        address, first, slot = np.unique(rows, return_index=True, return_inverse=True)
    stored, widths = code[first], np.array([kind.dtype.itemsize * 3 for kind in kinds])
    real = address >= 0
    tight = np.diff(address[real]) < widths[stored[real]][:-1]
    if (stored[slot] != code)[rows >= 0].any() or tight.any():
        raise FormatError("two POSITION accessors read the same bytes in different ways")
    values, groups = np.zeros((len(address), 3)), []
    for number, kind in enumerate(kinds):
        members = np.flatnonzero((stored == number) & real)
        if (address[members] % kind.dtype.itemsize).any():
            raise FormatError(
                f"a POSITION accessor starts at an address that is no multiple of {kind.dtype.itemsize}"
            )
        raw = _words(blob, kind.dtype)[_word_rows(address[members], kind.dtype)]
        values[members] = normalised(raw, kind.normalized)
        groups.append((kind, members))
    ends = np.cumsum([0, *[item.count for item in accessors]])
    slots = {item.index: slot[ends[i] : ends[i + 1]] for i, item in enumerate(accessors)}
    for item in accessors:
        finite = np.isfinite(values[slots[item.index]]).all(axis=1)
        if not finite.all():
            raise FormatError(
                f"accessor {item.index}, row {int(np.argmin(finite))} has a coordinate that is not finite"
            )
    return Points(address=address, values=values, groups=tuple(groups), slots=slots)
