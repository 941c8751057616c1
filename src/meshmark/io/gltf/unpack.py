"""A glTF whose data is compressed, as one whose data is not; everything else in it stays.

KHR_draco_mesh_compression replaces the data of a primitive, EXT_ and KHR_meshopt_compression the bytes of a
bufferView. Every bufferView keeps its number: a meshopt view gets the decoded bytes, the view of a Draco stream the
indices that were in it, and further views hold its attributes. All views come to lie in one buffer, so that no
compressed copy of the surface is left behind. See docs/decisions/0002-compressed-gltf.md.
"""

from __future__ import annotations

import copy
from collections.abc import Collection
from dataclasses import dataclass

from meshmark.errors import FormatError
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.draco import DRACO, Draco, draco_primitives, place_draco
from meshmark.io.gltf.schema import Json, integer
from meshmark.io.gltf.streams import Stream, decode_streams
from meshmark.io.gltf.views import MESHOPT, Views, extension, with_one_buffer

__all__ = ["COMPRESSIONS", "compressions", "unpacked"]

COMPRESSIONS = (DRACO, *MESHOPT)
"""The extensions that compress a mesh, each decoded on reading."""

_MODES = ("ATTRIBUTES", "TRIANGLES", "INDICES")
_FILTERS = ("NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR")


@dataclass(frozen=True, eq=False)
class _Packed:
    """A bufferView under a meshopt extension."""

    view: int
    stream: Stream


def compressions(container: Container) -> tuple[str, ...]:
    """Return the names of the extensions that compress data of this file."""
    found = {name for view in container.tables["bufferViews"] for name in MESHOPT if extension(view, name)}
    if draco_primitives(container):
        found.add(DRACO)
    return tuple(name for name in COMPRESSIONS if name in found)


def unpacked(container: Container) -> Container:
    """Return the same model without compression; the container itself where it has none.

    Raises `FormatError` where a stream is damaged or takes more than it may.
    """
    names = compressions(container)
    if not names:
        return container
    tree = copy.deepcopy(container.tree)
    packed = _packed_views(container)
    draco = draco_primitives(container)
    draco_streams = list(dict.fromkeys(item.view for item in draco))
    streams = [item.stream for item in packed]
    streams += [_draco_stream(container, draco, view) for view in draco_streams]
    found = decode_streams(streams)
    views = Views(container, tree)
    for item, arrays in zip(packed, found, strict=False):
        views.fill(item.view, arrays["rows"])
    place_draco(tree, views, draco, dict(zip(draco_streams, found[len(packed) :], strict=True)))
    for key in ("extensionsUsed", "extensionsRequired"):
        _without(tree, key, names)
    return with_one_buffer(container, tree, views)


def _without(tree: Json, key: str, names: Collection[str]) -> None:
    listed = tree.get(key)
    if isinstance(listed, list):
        tree[key] = [name for name in listed if name not in names]
        if not tree[key]:  # the specification knows no empty list
            del tree[key]


def _packed_views(container: Container) -> list[_Packed]:
    found = []
    for number, view in enumerate(container.tables["bufferViews"]):
        record = next((ext for name in MESHOPT if (ext := extension(view, name)) is not None), None)
        if record is not None:
            found.append(_Packed(number, _meshopt_stream(container, number, record)))
    return found


def _meshopt_stream(container: Container, number: int, record: Json) -> Stream:
    where = f"bufferView {number}"
    mode, filter_ = record.get("mode"), record.get("filter", "NONE")
    if mode not in _MODES or filter_ not in _FILTERS:
        raise FormatError(
            f"{where} is compressed with mode {mode!r} and filter {filter_!r}, expected known ones"
        )
    count, stride = integer(record, "count", where, None, 1), integer(record, "byteStride", where, None, 1)
    if stride > 256 or (mode == "ATTRIBUTES" and stride % 4):
        raise FormatError(
            f"{where} has compressed rows of {stride} bytes, expected 4 to 256, a multiple of 4"
        )
    start, size = container.span(record, where)
    data = container.blob[start : start + size].tobytes()
    given = {"mode": mode, "count": count, "stride": stride, "filter": filter_}
    return Stream(where=where, data=data, codec="meshopt", parameters=given, unpacked=count * stride)


def _draco_stream(container: Container, items: list[Draco], view: int) -> Stream:
    users = [item for item in items if item.view == view]
    ids = sorted({number for item in users for number in item.attributes.values()})
    start, size = container.view_span(view)
    claimed = max(item.claimed for item in users)
    data = container.blob[start : start + size].tobytes()
    return Stream(
        where=users[0].where, data=data, codec="draco", parameters={"attributes": ids}, unpacked=claimed
    )
