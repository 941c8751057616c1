"""Who else reads the bytes of a position: the check that moving one changes nothing but positions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import Accessor, open_accessor
from meshmark.io.gltf.container import Container
from meshmark.io.gltf.points import Points
from meshmark.io.gltf.schema import Json, objects

__all__ = ["check_uses", "position_accessors"]

# One use of bytes: who, address of the first row, stride, bytes per row, rows.
_Use = tuple[str, int, int, int, int]


def position_accessors(container: Container) -> list[int]:
    """Return the accessors that any primitive, of whatever mode and shown or not, uses as POSITION only."""
    uses = _accessor_uses(container)
    return sorted(index for index, names in uses.items() if names == {"POSITION"})


def check_uses(container: Container, points: Points, moved: NDArray[np.bool_]) -> None:
    """Raise `FormatError` where the bytes of a slot that moves also serve as something else."""
    mask = np.zeros(len(container.blob), dtype=bool)
    for kind, members in points.groups:
        address = points.address[members[moved[members]]]
        for byte in range(3 * kind.dtype.itemsize):
            mask[address + byte] = True
    for who, start, stride, size, count in _foreign(container):
        if np.ndarray((count, size), bool, mask.data, start, (stride, 1)).any():
            raise FormatError(
                f"{who} shares bytes with positions, so these cannot be moved alone: export the model "
                "with separate data for each first"
            )


def _accessor_uses(container: Container) -> dict[int, set[str]]:
    tables, uses = container.tables, dict[int, set[str]]()
    for mesh in tables["meshes"]:
        for primitive in objects(mesh, "primitives"):
            _note(uses, primitive.get("attributes"), "")
            _note(uses, {"indices": primitive.get("indices")}, "")
            for target in objects(primitive, "targets"):
                _note(uses, target, "target ")
    for animation in tables["animations"]:
        for sampler in objects(animation, "samplers"):
            _note(uses, sampler, "animation ")
    for skin in tables["skins"]:
        _note(uses, {"skin": skin.get("inverseBindMatrices")}, "")
    return uses


def _note(uses: dict[int, set[str]], table: object, prefix: str) -> None:
    for name, index in table.items() if isinstance(table, dict) else ():
        if isinstance(index, (int, float)) and index == int(index):
            uses.setdefault(int(index), set()).add(prefix + name)


def _foreign(container: Container) -> Iterator[_Use]:
    """Yield every use of bytes that is not purely a position."""
    uses = _accessor_uses(container)
    for index in range(len(container.tables["accessors"])):
        names = uses.get(index, set())
        try:
            accessor = open_accessor(container, index)
        except FormatError:
            continue  # nobody can read it, so nobody can notice a change
        if (sparse := accessor.sparse) is not None:
            who = f"accessor {index} (sparse indices)"
            yield who, sparse.indices, sparse.index_bytes, sparse.index_bytes, len(sparse.rows)
        if names and names != {"POSITION"}:
            yield from _rows(accessor, "/".join(sorted(names)))
    for number, image in enumerate(container.tables["images"]):
        yield from _image(container, number, image)


def _rows(accessor: Accessor, names: str) -> Iterator[_Use]:
    who, size = f"accessor {accessor.index} ({names})", accessor.row_bytes
    if accessor.start is not None:
        yield who, accessor.start, accessor.stride, size, accessor.count
    if accessor.sparse is not None:
        yield who, accessor.sparse.values, size, size, len(accessor.sparse.rows)


def _image(container: Container, number: int, image: Json) -> Iterator[_Use]:
    view = image.get("bufferView")
    try:
        if isinstance(view, int) and 0 <= view < len(container.tables["bufferViews"]):
            start, size = container.view_span(view)
            yield f"image {number}", start, 1, 1, size
    except FormatError:
        return
