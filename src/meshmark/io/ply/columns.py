"""Where the values of PLY elements stand in the data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.ply.data import PlyData
from meshmark.io.ply.header import Element, PlyHeader, Property
from meshmark.io.wording import amount, surplus
from meshmark.mesh import IntArray

__all__ = ["Columns", "lay_out"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Columns:
    """Where an element's values stand.

    places: property name -> (rows,) place of its value, or of its first list member, ascending.
    counts: list property name -> (rows,) members.
    """

    element: Element
    places: dict[str, IntArray]
    counts: dict[str, IntArray]


def lay_out(header: PlyHeader, data: PlyData) -> tuple[dict[str, Columns], tuple[str, ...]]:
    """Return where the values of each element stand, by its name, and what the user should know of it.

    The last element may have rows fewer than declared, each complete, and more may follow it.
    Raises `FormatError` where the data end anywhere else, or where vertices may be missing or uncounted.
    """
    columns = {}
    place = data.begin
    remarks: tuple[str, ...] = ()
    last = max((k for k, element in enumerate(header.elements) if element.rows), default=-1)
    for number, element in enumerate(header.elements):
        laid = _uniform(element, data, place) or _row_by_row(element, data, place, number == last)
        columns[element.name], place = laid
        found = len(next(iter(laid[0].places.values()), ()))
        if element.properties and found < element.rows:
            remarks = (f"the header declares {element.rows:,} rows of '{element.name}', {found:,} are there",)
    if place < data.end:
        _check_surplus(header.elements[last], data, place)
        remarks = (surplus(data.end - place, *data.unit),)
    return columns, remarks


def _check_surplus(last: Element, data: PlyData, place: int) -> None:
    """Raise `FormatError` where what follows may be vertices that the header does not count."""
    row = sum(data.width(entry.dtype) for entry in last.properties if entry.count is None)
    if last.name == "vertex" and data.end - place >= row:
        raise FormatError(
            f"the header declares {last.rows} vertices, but behind them stands what may be further ones: "
            f"{amount(data.end - place, *data.unit)}"
        )


def _uniform(element: Element, data: PlyData, begin: int) -> tuple[Columns, int] | None:
    """Lay out rows whose lists are all as long as those of the first row; None where they are not."""
    offsets, counts, stride = {}, {}, 0
    for entry in element.properties if element.rows else ():
        if entry.count is not None:
            counts[entry.name] = _list_length(entry, data, begin + stride)
            stride += data.width(entry.count)
        offsets[entry.name] = stride
        stride += counts.get(entry.name, 1) * data.width(entry.dtype)
    end = begin + element.rows * stride
    if end > data.end and not counts:
        raise _too_short(element)
    if end > data.end or (element.rows and not stride):
        return None
    rows = begin + stride * np.arange(element.rows)
    for entry in element.properties:
        if entry.count is not None and element.rows:
            heads = rows + (offsets[entry.name] - data.width(entry.count))
            if not _all_equal(data, heads, entry, counts[entry.name]):
                return None
    places = {entry.name: rows + offsets.get(entry.name, 0) for entry in element.properties}
    sizes = {
        entry.name: np.broadcast_to(np.int64(counts.get(entry.name, 0)), element.rows)  # takes no room
        for entry in element.properties
        if entry.count is not None
    }
    return Columns(element=element, places=places, counts=sizes), end


def _all_equal(data: PlyData, heads: IntArray, entry: Property, size: int) -> bool:
    if entry.count is None:
        return False
    try:
        return bool((data.values(heads, entry.count) == size).all())
    except FormatError:
        # In a text, what stands there need not even be a whole number: the rows are not alike.
        return False


def _row_by_row(element: Element, data: PlyData, place: int, last: bool) -> tuple[Columns, int]:
    """Lay out rows whose lists differ in length: each row tells where the next begins.

    last: no other element follows; then the data may end before all rows are there, but not within one.
    """
    places: dict[str, list[int]] = {entry.name: [] for entry in element.properties}
    counts: dict[str, list[int]] = {e.name: [] for e in element.properties if e.count is not None}
    steps = [(entry, data.width(entry.dtype), places[entry.name].append) for entry in element.properties]
    if not steps:
        raise FormatError(f"the header declares '{element.name}' without properties")
    for row in range(element.rows):
        if place == data.end and row and last and counts and data.whole:
            break
        for entry, width, note in steps:
            size = 1
            if entry.count is not None:
                size = _list_length(entry, data, place)
                counts[entry.name].append(size)
                place += data.width(entry.count)
            note(place)
            place += size * width
        if place > data.end:
            raise _too_short(element)
    arrays = {name: np.array(values, dtype=np.int64) for name, values in places.items()}
    sizes = {name: np.array(values, dtype=np.int64) for name, values in counts.items()}
    return Columns(element=element, places=arrays, counts=sizes), place


def _list_length(entry: Property, data: PlyData, place: int) -> int:
    if entry.count is None or place + data.width(entry.count) > data.end:
        raise FormatError(f"the data end before a list '{entry.name}' that the header declares")
    size = data.count(place, entry.count)
    if not 0 <= size <= data.end - place:
        raise FormatError(f"a list '{entry.name}' declares {size} members, more than the file can hold")
    return size


def _too_short(element: Element) -> FormatError:
    return FormatError(
        f"the data end within the {element.rows} rows of '{element.name}' that the header declares"
    )
