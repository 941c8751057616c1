"""The table of codecs that compress the data of a glTF. Called in a process of its own only, see `streams`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.meshopt_filters import FILTERS
from meshmark.io.gltf.meshopt_index import decode_sequence, decode_triangles
from meshmark.io.gltf.meshopt_vertex import decode_vertices

__all__ = ["CODECS", "decode"]

Arrays = dict[str, NDArray[Any]]

_DRACO = b"DRACO"


def decode(stream: bytes, codec: str, **parameters: Any) -> Arrays:
    """Return the arrays of a stream by name. Raises `FormatError` where it is none of its codec."""
    return CODECS[codec](stream, **parameters)


def _meshopt(stream: bytes, mode: str, count: int, stride: int, filter: str) -> Arrays:
    """Return "rows" (count, stride) of uint8."""
    if mode == "ATTRIBUTES":
        undo, strides = FILTERS[filter]
        if stride not in strides:
            raise FormatError(f"the meshopt filter {filter} does not take rows of {stride} bytes")
        return {"rows": undo(decode_vertices(stream, count, stride))}
    if stride not in (2, 4) or filter != "NONE":
        raise FormatError(
            f"a meshopt stream of mode {mode} has indices of {stride} bytes and filter {filter}"
        )
    indices = (decode_triangles if mode == "TRIANGLES" else decode_sequence)(stream, count)
    # As in the reference: of an index that two bytes do not hold the lower two are kept.
    return {"rows": indices.astype(f"<u{stride}").view(np.uint8).reshape(count, stride)}


def _draco(stream: bytes, attributes: list[int]) -> Arrays:
    """Return "faces" (m, 3) and, under its unique id, each attribute (n, width) that is asked for."""
    import DracoPy

    try:
        mesh = DracoPy.decode(stream)
        faces = np.asarray(mesh.faces)
        found = {entry["unique_id"]: np.asarray(entry["data"]) for entry in mesh.attributes}
    except MemoryError:
        raise
    except Exception:  # the library says "not draco encoded" of whatever it cannot decode
        if not stream.startswith(_DRACO):
            raise FormatError("a Draco stream does not start with its header 'DRACO'") from None
        raise FormatError("a Draco stream is damaged: the Draco library cannot decode it") from None
    missing = [number for number in attributes if number not in found]
    if missing:
        raise FormatError(f"a Draco stream holds no attribute with the id {missing[0]}")
    named = {str(number): found[number].reshape(len(found[number]), -1) for number in attributes}
    return {"faces": faces.reshape(-1, 3), **named}


# Each takes a stream and the parameters that the JSON gives for it.
CODECS: dict[str, Callable[..., Arrays]] = {"meshopt": _meshopt, "draco": _draco}
