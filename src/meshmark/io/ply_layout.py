"""Where the values of PLY elements stand in the data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.ply_data import PlyData
from meshmark.io.ply_header import Element, PlyHeader, Property
from meshmark.mesh import IntArray

__all__ = ["Columns", "lay_out"]


@dataclass(frozen=True, eq=False)
class Columns:
    """Where an element's values stand.

    places: property name -> (rows,) place of its value, or of its first list member, ascending.
    counts: list property name -> (rows,) members.
    """

    element: Element
    places: dict[str, IntArray]
    counts: dict[str, IntArray]


def lay_out(header: PlyHeader, data: PlyData) -> dict[str, Columns]:
    """Return where the values of each element stand, by its name.

    Raises `FormatError` where the data do not end exactly where the header says.
    """
    columns = {}
    place = data.begin
    for element in header.elements:
        laid = _uniform(element, data, place) or _row_by_row(element, data, place)
        columns[element.name], place = laid
    if place != data.end:
        raise FormatError(f"{data.end - place} {data.unit} follow the data that the header declares")
    return columns


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
        entry.name: np.full(element.rows, counts.get(entry.name, 0))
        for entry in element.properties
        if entry.count is not None
    }
    return Columns(element, places, sizes), end


def _all_equal(data: PlyData, heads: IntArray, entry: Property, size: int) -> bool:
    if entry.count is None:
        return False
    try:
        return bool((data.values(heads, entry.count) == size).all())
    except FormatError:
        # In a text, what stands there need not even be a whole number: the rows are not alike.
        return False


def _row_by_row(element: Element, data: PlyData, place: int) -> tuple[Columns, int]:
    """Lay out rows whose lists differ in length: each row tells where the next begins."""
    places: dict[str, list[int]] = {entry.name: [] for entry in element.properties}
    counts: dict[str, list[int]] = {e.name: [] for e in element.properties if e.count is not None}
    steps = [(entry, data.width(entry.dtype), places[entry.name].append) for entry in element.properties]
    if not steps:
        raise FormatError(f"the header declares '{element.name}' without properties")
    for _ in range(element.rows):
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
    return Columns(element, arrays, sizes), place


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
