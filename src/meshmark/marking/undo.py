"""Undo data: what takes both layers' changes off a marked model again, kept in its certificate for the key's owner.

The displacement of each vertex, in canonical coordinates and whole steps, is predicted from neighbours on the
mesh, compressed, and sealed (`sealing`), so that the certificate stays safe to hand out. It is bound to the faces,
not to the place: a turned, scaled or moved copy can be unmarked, too.
"""

from __future__ import annotations

import base64
import lzma
from collections.abc import Iterator
from dataclasses import dataclass, replace
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from meshmark.authentication.as_written import with_written
from meshmark.authentication.shown_otherwise import with_shown
from meshmark.certificate.binding import bound, mismatch, refuse_edited
from meshmark.certificate.certificate import Certificate
from meshmark.certificate.sealing import TAG_BYTES, open_sealed, seal
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.extent import diagonal
from meshmark.geometry.frame import Frame, frame_alternatives
from meshmark.geometry.kd_tree import kd_tree
from meshmark.geometry.registration.corner_matching import match_corners
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.io.file_precision import conform
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.search.starting_frames import frame_of
from meshmark.scene.distinct import distinct
from meshmark.scene.surfaces import surfaces_to_read

__all__ = ["FIELD", "STEP", "Unmarked", "sealed", "unmark", "with_undo"]

FIELD = "undo"
"""Name of the certificate's field."""
STEP = 2.5e-7
"""Step of a displacement's coordinates over the diagonal."""
VERSION = 2
_SEAL = "undo seal"
DIGEST_BYTES = 16
# Vertices are coded in levels, each predicted from those before it: (one vertex in N, edges averaged over).
LEVELS = ((256, 0), (64, 16), (16, 8), (4, 4), (1, 2))
# Corners this near to points, in units of the frame, are where the certificate says: what is left is rounding.
SAME = 1e-6
# The area of a surface over its size squared, in its own frame and in the certificate's, differs by less than this.
SAME_AREA = 1e-2
_FILTERS = [{"id": lzma.FILTER_LZMA2, "preset": 6}]


@dataclass(frozen=True, eq=False, kw_only=True)
class Unmarked:
    """A model without its mark.

    mesh: positions as its file can hold them; exact: the marked model was as it was signed off, so this is the
    original, of which no vertex is farther off than within_over_diagonal (of the original's diagonal; a bound, from
    the step that displacements are kept with and from what this file rounded). rms_over_diagonal: of what was taken
    off.
    """

    mesh: Mesh
    exact: bool
    within_over_diagonal: float
    rms_over_diagonal: float


def sealed(
    certificate: Certificate, original: Mesh | None, marked: Mesh, key: Key, identity: int
) -> Certificate:
    """Return the certificate of `marked` bound to key and id, with undo data where there is an original.

    It keeps how the marked file shows something else than its surface, and that of a model with the id alone also
    what the model was like.
    """
    made = with_shown(certificate, marked.document, key)
    if made.more.get("layers") == "ownership":
        made = with_written(made, marked, key)
    if original is not None:
        made = with_undo(made, original, marked, key)
    return bound(made, key, identity)


def with_undo(certificate: Certificate, original: Mesh, marked: Mesh, key: Key) -> Certificate:
    """Return the certificate of `marked` with what turns it back into `original`, readable with the key only.

    Raises `InputError` where the meshes do not have the same faces and number of vertices.
    """
    once = distinct(marked)  # all copies were moved as one
    if once is not None and original.vertices.shape == once.scene.vertices.shape:
        original, marked = Mesh(original.vertices[once.rows], once.mesh.faces), once.mesh
    if original.vertices.shape != marked.vertices.shape or not np.array_equal(original.faces, marked.faces):
        raise InputError("the original and the marked model differ in their faces, expected the same model")
    frame = certificate.frame
    step = STEP * _diagonal(marked) / frame.scale
    whole = np.rint((original.vertices - marked.vertices) @ frame.axes / (frame.scale * step))
    if np.abs(whole).max(initial=0.0) >= 2.0**31:
        raise InputError("a vertex of the original lies far off the marked one, expected a marked model")
    head = np.array([step], "<f8").tobytes() + _digest(marked.faces) + _digest(marked.vertices)
    body = _compressed(_residuals(whole.astype(np.int64), _Predictor(marked, frame)))
    value = {
        "version": VERSION,
        "data": base64.b64encode(seal(head + body, key, _SEAL)).decode("ascii"),
    }
    return replace(certificate, more={**certificate.more, FIELD: value})


def unmark(mesh: Mesh, key: Key, certificate: Certificate) -> Unmarked:
    """Return the mesh without its mark.

    Parameters
    ----------
    mesh : Mesh
        A marked model, in the vertex order that it was marked in.
    key : Key
    certificate : Certificate
        That was made when the model was marked.

    Returns
    -------
    Unmarked

    Raises
    ------
    InputError
        The certificate has no undo data, was changed, or belongs to another key or model.
    """
    once = distinct(mesh)
    if once is not None:
        found = unmark(once.mesh, key, certificate)
        return replace(found, mesh=once.whole(found.mesh.vertices))
    data, remark = _data(certificate), mismatch(certificate, key, None)
    if remark is not None:
        raise InputError(f"{remark[:1].lower()}{remark[1:].rstrip('.')}")
    refuse_edited(certificate, key)
    plain = open_sealed(data, key, _SEAL)
    start = 8 + 2 * DIGEST_BYTES
    step = float(np.frombuffer(plain[:8], "<f8")[0])
    faces, positions = plain[8 : 8 + DIGEST_BYTES], plain[8 + DIGEST_BYTES : start]
    if faces != _digest(mesh.faces):
        raise InputError(
            "the model's faces are not those that were marked, expected this certificate's model in the vertex "
            "order it was marked in, which other programs and formats may change"
        )
    frame = certificate.frame if positions == _digest(mesh.vertices) else _frame(mesh, certificate)
    whole = _restored(_expanded(plain[start:], len(mesh.vertices)), _Predictor(mesh, frame))
    shift = whole @ frame.axes.T * (step * frame.scale)
    moved = np.asarray(whole.any(axis=1))
    vertices = np.where(moved[:, None], mesh.vertices + shift, mesh.vertices)
    result = mesh.with_vertices(conform(mesh, vertices))
    rms = float(np.sqrt(np.einsum("ij,ij->", shift, shift) / max(len(shift), 1)))
    within = _bound(result, vertices, step * frame.scale)
    return Unmarked(
        mesh=result,
        exact=positions == _digest(mesh.vertices),
        within_over_diagonal=within,
        rms_over_diagonal=rms / _diagonal(mesh),
    )


def _bound(result: Mesh, vertices: FloatArray, step: float) -> float:
    """Return how far off the original, over its diagonal, a vertex of `result`, rounded from `vertices`, may be.

    Half a step (scene units) on each axis, the file's rounding, and that of the sums here; the original's diagonal
    is shorter than the result's by twice as much at most.
    """
    rounded = float(np.sqrt(((result.vertices - vertices) ** 2).sum(axis=1).max(initial=0.0)))
    sums = 16.0 * float(np.finfo(float).eps) * float(np.abs(vertices).max(initial=0.0))
    off = np.sqrt(3.0) / 2.0 * step + rounded + sums
    return float(off / (_diagonal(result) - 2.0 * off))


def _diagonal(mesh: Mesh) -> float:
    return diagonal(mesh.vertices, mesh.faces)


def _digest(array: FloatArray | IntArray) -> bytes:
    kind = "<i8" if array.dtype.kind == "i" else "<f8"
    content = np.ascontiguousarray(array + 0, dtype=kind).tobytes()
    return blake2b(content, digest_size=DIGEST_BYTES, person=b"meshmark undo 1").digest()


def _frame(mesh: Mesh, certificate: Certificate) -> Frame:
    """Return the certificate's frame where the mesh lies there, else that in which its corners lie nearest to it.

    A certificate without corners has landmarks, which say in which turn of the mesh's own frame it lies.
    """
    signed = certificate.frame
    surface = _signed_off(mesh, signed)
    tree = kd_tree(surface.points)
    corners = certificate.corners
    places = corners.reshape(-1, 3) if len(corners) else certificate.landmarks.places

    def left(frame: Frame) -> float:
        """Return how far places of the certificate are from points, on average, in units of the frame."""
        return float(np.mean(tree.query(frame.to_scene(places))[0])) / frame.scale if len(places) else 0.0

    if len(corners) and left(signed) < SAME:
        return signed
    frames = [frame_of(fit, signed) for fit in match_corners(corners, surface.points, surface.faces)]
    return min([signed, *frames, *frame_alternatives(surface.frame, True)], key=left)


def _signed_off(mesh: Mesh, signed: Frame) -> Surface:
    """Return the surface that was signed: of a scene perhaps that without its copies."""
    found = []
    for surface in surfaces_to_read(mesh):
        found.append(surface)
        if abs(surface.frame.area / signed.area - 1.0) < SAME_AREA:
            return surface
    return found[0]


def _levels(count: int) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.bool_], int]]:
    """Yield which vertices are known, which come next, and over how many edges known ones are averaged."""
    word = (np.arange(count, dtype=np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    share = ((word ^ (word >> np.uint64(31))) * np.uint64(0xBF58476D1CE4E5B9)) >> np.uint64(40)
    known = np.zeros(count, bool)
    for one_in, reach in LEVELS:
        coming = (share % np.uint64(one_in) == 0) & ~known
        yield known, coming, reach
        known = known | coming


class _Predictor:
    """Predicts displacements along the normals of the marked surface from those of vertices nearby on the mesh."""

    def __init__(self, mesh: Mesh, frame: Frame) -> None:
        surface = surface_of(mesh)
        normals = vertex_normals(frame.to_canonical(surface.points), surface.faces)
        self.normals = normals[surface.point_of_vertex]
        self.walk = csr_array(adjacency(unique_edges(mesh.faces), len(mesh.vertices)))

    def __call__(self, values: IntArray, known: NDArray[np.bool_], reach: int) -> IntArray:
        """Return (n, 3): the mean height of known vertices over `reach` edges, as a rounded vector; else 0."""
        heights = np.einsum("ij,ij->i", values, self.normals) * known
        spread = np.stack([heights, known.astype(float)], axis=1)
        for _ in range(reach):
            spread = spread + self.walk @ spread
            spread /= float(spread[:, 1].max())
        total = spread[:, 1]
        mean = np.divide(spread[:, 0], total, out=np.zeros(len(values)), where=total > 1e-9)
        return np.asarray(np.rint(mean[:, None] * self.normals), np.int64)


def _residuals(values: IntArray, predict: _Predictor) -> IntArray:
    """Return (n, 3): what predictions leave over."""
    out = values.copy()
    for known, coming, reach in _levels(len(values)):
        if known.any():
            out[coming] -= predict(values, known, reach)[coming]
    return out


def _restored(residuals: IntArray, predict: _Predictor) -> IntArray:
    values = residuals.copy()
    for known, coming, reach in _levels(len(values)):
        if known.any():
            values[coming] += predict(values, known, reach)[coming]
    return values


def _compressed(residuals: IntArray) -> bytes:
    """Return the residuals, sign in the lowest bit, byte plane by byte plane, compressed."""
    coded = np.where(residuals < 0, -2 * residuals - 1, 2 * residuals).T.astype("<u4")
    planes = coded.ravel().view(np.uint8).reshape(-1, 4).T
    return lzma.compress(planes.tobytes(), lzma.FORMAT_RAW, filters=_FILTERS)


def _expanded(content: bytes, count: int) -> IntArray:
    planes = np.frombuffer(lzma.decompress(content, lzma.FORMAT_RAW, filters=_FILTERS), np.uint8)
    coded = np.ascontiguousarray(planes.reshape(4, -1).T).view("<u4").reshape(3, count).T.astype(np.int64)
    return np.where(coded % 2 == 1, -(coded + 1) // 2, coded // 2)


def _data(certificate: Certificate) -> bytes:
    value = certificate.more.get(FIELD)
    if not isinstance(value, dict):
        raise InputError("the certificate has no undo data, expected one made by `embed` with this model")
    if value.get("version") != VERSION:
        raise InputError(
            f"the certificate's undo data has version {value.get('version')!r}, expected {VERSION}"
        )
    text = value.get("data")
    try:
        content = base64.b64decode(text if isinstance(text, str) else "-", validate=True)
    except ValueError:
        raise InputError("the certificate's undo data is not in base64") from None
    if len(content) < TAG_BYTES + 8 + 2 * DIGEST_BYTES:
        raise InputError(f"the certificate's undo data has {len(content)} bytes, expected more")
    return content
