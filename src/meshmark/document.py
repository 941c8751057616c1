"""What every file format offers: a document that knows its bytes and how to patch positions into them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from meshmark.arrays import FloatArray, IntArray

__all__ = ["KINDS", "Attributes", "Deviation", "Document"]

KINDS = (
    "morph_weights",
    "skin",
    "scene",
    "instancing",
    "lines",
    "points",
    "hidden_material",
    "hidden_node",
    "levels_of_detail",
    "morph_animation",
    "skeletal_animation",
    "node_animation",
    "pointer_animation",
)
"""Ways in which a viewer shows something else than the surface; a kind's place in this list is kept in payloads."""


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """A way in which viewers of a file show something else than the surface that is read from it.

    kind: one of `KINDS`. amount: above 0; what it measures depends on the kind. morph_weights, skin: largest
    displacement over the diagonal; scene, hidden_material, hidden_node: share of the faces that is not shown;
    lines: their length over the diagonal; points, instancing: how many, over 1000; 1 of all others.
    """

    kind: str
    amount: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Attributes:
    """Per-vertex data that a conversion to another format may keep, aligned with `Document.vertices`.

    normals:   (n, 3) float64 or None.
    texcoords: (n, 2) float64, origin at the lower left as in OBJ, or None.
    colors:    (n, 4) uint8 RGBA, or None.
    other:     short names of what else the file holds and no other format can keep
               ("materials", "skins", "groups", ...), for the sentence that says what a conversion drops.
    seams:     for formats whose corners of one vertex may carry different attributes (OBJ): a pair
               (points, faces); then the arrays above are aligned with points, (k,) vertex indices, and
               faces, (m, 3), indexes them. None: aligned with the vertices. Converters never see it:
               `write_mesh` splits the vertices first, where the target keeps such attributes.
    """

    normals: FloatArray | None = None
    texcoords: FloatArray | None = None
    colors: NDArray[np.uint8] | None = None
    other: tuple[str, ...] = ()
    seams: tuple[IntArray, IntArray] | None = None


class Document(Protocol):
    """A parsed file. Immutable: `patched` returns new bytes and leaves the document as it was.

    format:     a key of `meshmark.io.FORMATS`: "off", "obj", "ply", "stl", "glb", "gltf", "3mf".
    vertices:   (n, 3) float64, scene coordinates (node transforms, units and instances applied),
                one row for each vertex the file stores (and for each instance of it), in file order;
                vertices that no face uses and whose coordinates are not finite are left out.
    faces:      (m, 3) int64, polygons triangulated, degenerate triangles kept.
    remarks:    clauses such as "1 byte follows the data that the header declares, and is kept"; mostly none.
    """

    @property
    def format(self) -> str:
        """Return the key in `FORMATS`."""
        ...

    @property
    def vertices(self) -> FloatArray:
        """Return the (n, 3) positions read."""
        ...

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return sentences about what the user should know of how the file was read."""
        ...

    @property
    def faces(self) -> IntArray:
        """Return the (m, 3) triangles."""
        ...

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the (n, 3) positions that the file would hold, after its own precision, for these."""
        ...

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        """Return the files to write, name -> bytes, the first of them called `name`.

        Rows equal to `self.vertices` keep their original bytes; with no row changed every file is
        byte-identical to what was read.
        """
        ...

    def attributes(self) -> Attributes:
        """Return what a conversion to another format may keep."""
        ...

    def summary(self) -> dict[str, Any]:
        """Return what `meshmark info` prints beside counts: encoding, precision, meshes, materials, ..."""
        ...

    def deviations(self) -> tuple[Deviation, ...]:
        """Return in which ways a viewer shows something else than the surface, in the order of `KINDS`."""
        ...

    def looks(self) -> tuple[str, ...] | None:
        """Return what the surface is painted with, in words without names; None where that is not read."""
        ...

    def side_files(self) -> tuple[Path, ...]:
        """Return existing files that the file refers to and `patched` does not return (materials, images).

        A save into another folder copies them there, keeping their place relative to the model file;
        a save never writes over one of them. Only relative references inside the model's folder count.
        """
        ...
