"""Recovery with the original at hand: altered parts come back vertex for vertex, as they were signed off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.coarse_digits import coarse_digits
from meshmark.authentication.examination import Examination, examine
from meshmark.authentication.part_recovery import Recovery, recover_by_miniature, unrecovered
from meshmark.authentication.recovered_file import in_file
from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.extent import diagonal
from meshmark.geometry.frame import Frame
from meshmark.geometry.similarity import Similarity
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.io.derived import losses
from meshmark.marking.marked_again import marked_again
from meshmark.marking.verification import authentic
from meshmark.mesh import Mesh
from meshmark.ownership.search.starting_frames import corner_frames, starting_frames
from meshmark.recovery.whole_again import whole_again
from meshmark.recovery.whole_placement import PlacedWhole, place_whole
from meshmark.scene.distinct import distinct
from meshmark.scene.surfaces import Unfolded, marked_surface
from meshmark.threads import on_one_thread

__all__ = ["recover"]

# How far off their places in the marked copy points may be that were not moved, over the diagonal: what floats
# round after a similarity transform; or this multiple of what the suspect's file was rounded to, on each axis.
_SAME, _ROUNDED = 1e-6, 2.0
# How far off intact points may be from another marked copy, and from the unmarked original.
_COPY, _MARKED = 1e-4, 6e-3


@on_one_thread
def recover(
    mesh: Mesh,
    key: Key,
    *,
    reference: Certificate | Mesh | None = None,
    original: Mesh | None = None,
    copy: Mesh | None = None,
) -> Recovery:
    """Return the mesh with altered parts brought back, and everything else bit by bit as it is.

    Without the original or the marked copy moved parts return to the miniature that the intact part carries,
    foreign ones go, holes are filled. With the marked copy altered vertices return to their places in it, and what
    is gone comes back, vertex for vertex. So they do with the original, from which that copy is made again; where
    it cannot be, to their places in the original.

    Parameters
    ----------
    mesh : Mesh
        The suspect; it may have been turned, resized and moved, and have another order of vertices.
    key : Key
        That it was marked with.
    reference : Certificate or Mesh, optional
        The certificate or the unmarked original, which helps to find the mark. With the original, a certificate
        also saves the search for strength and layers.
    original : Mesh, optional
        The unmarked original that parts are taken from.
    copy : Mesh, optional
        The marked copy, as it was signed off, that parts are taken from instead.

    Returns
    -------
    Recovery

    Raises
    ------
    InputError
        The mesh, the original or the copy has no surface, the certificate of this key was edited, or both the
        original and a copy are given.
    """
    if original is not None and copy is not None:
        raise InputError("the original and a marked copy exclude each other, expected one of them")
    if copy is not None:
        return _from_copy(mesh, key, reference, copy)
    if original is None:
        return recover_by_miniature(mesh, key, reference=reference)
    start = perf_counter()
    found = examine(mesh, key, original if reference is None else reference)
    if found.marked and not found.altered.any() and not found.points_missing:
        return Recovery(mesh=mesh, advice="Nothing was altered.", seconds=perf_counter() - start)
    share = float(found.surface.point_shares[found.altered].sum()) if found.marked else 0.0
    if found.id is None:
        return unrecovered(share, "No mark of this key was found.", start)
    if distinct(mesh) is not None and distinct(original) is None:
        why = "The model's file shows one mesh several times, that of the original does not."
        return unrecovered(share, why, start)
    certificate = reference if isinstance(reference, Certificate) and found.remark is None else None
    suspect = _Suspect(mesh=mesh, found=found, original=original)
    again = marked_again(original, key, found, certificate, lambda copy: suspect.placed(copy, _COPY))
    whole, placed = (original, None) if again is None else (again.mesh, again.placed)
    if placed is None:
        if not found.marked:
            why = (
                "No mark of authentication holds, and the marked copy cannot be made again from the original: "
                "nothing tells which parts were altered."
            )
            return unrecovered(share, why, start)
        placed = suspect.placed(original, _MARKED)
    if placed is None:
        return unrecovered(share, "The original does not fit what is intact of the model.", start)
    return _restored(suspect, whole, placed, exact=again is not None, key=key, start=start)


def _from_copy(mesh: Mesh, key: Key, reference: Certificate | Mesh | None, copy: Mesh) -> Recovery:
    """Return the mesh with altered parts as the marked copy has them."""
    start = perf_counter()
    found = examine(mesh, key, reference)
    if found.marked and not found.altered.any() and not found.points_missing:
        return Recovery(mesh=mesh, advice="Nothing was altered.", seconds=perf_counter() - start)
    share = float(found.surface.point_shares[found.altered].sum()) if found.marked else 0.0
    if (distinct(mesh) is None) != (distinct(copy) is None):
        return unrecovered(
            share, "Only one of the model and its marked copy shows a mesh several times.", start
        )
    suspect = _Suspect(mesh=mesh, found=found, original=copy)
    placed = suspect.placed(copy, _COPY)
    if placed is None:
        return unrecovered(share, "The marked copy does not fit what is intact of the model.", start)
    return _restored(suspect, copy, placed, exact=True, key=key, start=start)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Suspect:
    """A suspect, what its marks say, and the original that it is compared with."""

    mesh: Mesh
    found: Examination
    original: Mesh

    @cached_property
    def surface(self) -> Surface:
        """Its surface; with all copies where they are known by their shape alone."""
        return surface_of(self.mesh) if isinstance(self.found.surface, Unfolded) else self.found.surface

    @cached_property
    def altered(self) -> NDArray[np.bool_]:
        """(p,) points that marks call altered, none where no mark holds."""
        altered = np.zeros(len(self.surface.points), bool)
        if self.found.marked:
            of_vertex = self.found.altered[self.found.surface.point_of_vertex]
            altered[self.surface.point_of_vertex[of_vertex]] = True
        return altered

    @cached_property
    def by_corners(self) -> list[Similarity]:
        """Similarities from the original, and so from its copies, by triangles that the suspect still has."""
        return self._poses(corner_frames(self.surface, self.original))

    @cached_property
    def by_landmarks(self) -> list[Similarity]:
        """The same by registration, which takes longer."""
        return self._poses(starting_frames(self.surface, self.original))

    def _poses(self, frames: list[Frame]) -> list[Similarity]:
        home = _to_scene(marked_surface(self.original).frame).inverse()
        return [_to_scene(frame).after(home) for frame in frames]

    def guesses(self) -> Iterator[Similarity]:
        """Yield how the original may lie in the suspect, what is cheap first."""
        yield Similarity.identity()
        yield from self.by_corners
        yield from self.by_landmarks

    def of_whole(self, whole: Mesh) -> Surface:
        """Return the surface of a copy that corresponds to `surface`."""
        return surface_of(whole) if distinct(self.mesh) is None else marked_surface(whole)

    def placed(self, whole: Mesh, within: float) -> PlacedWhole | None:
        """Return how a copy of the original lies in the suspect."""
        whole_surface, intact = self.of_whole(whole), ~self.altered
        return place_whole(self.surface, whole_surface, intact, self.guesses, same=self.same, within=within)

    @cached_property
    def same(self) -> float:
        """How near its place a point lies that was not moved, over the diagonal."""
        coarse = coarse_digits(self.mesh.vertices)
        half = 0.0 if coarse is None else coarse.half
        return max(_SAME, _ROUNDED * half / diagonal(self.surface.points, self.surface.faces))


def _to_scene(frame: Frame) -> Similarity:
    return Similarity(scale=frame.scale, rotation=frame.axes, shift=frame.centre)


def _restored(
    suspect: _Suspect, whole: Mesh, placed: PlacedWhole, *, exact: bool, key: Key, start: float
) -> Recovery:
    """Return the suspect with what is altered as the whole has it; exact: the whole is the marked copy."""
    altered = suspect.altered | placed.moved if exact else suspect.altered
    surface = suspect.surface
    share = float(surface.point_shares[altered | (placed.match < 0)].sum())
    made = whole_again(surface, altered, placed.match, placed.points, suspect.of_whole(whole).faces)
    file = in_file(suspect.mesh, surface, made)
    added = int(made.added.sum())
    if not (file.moved or file.removed or added):
        return Recovery(mesh=suspect.mesh, advice="Nothing was altered.", seconds=perf_counter() - start)
    advice = "The altered parts are back as they were signed off, from the marked copy."
    if not exact:
        advice = (
            "The altered parts are back as the unmarked original has them: the marked copy could not be made again "
            "from it, so they carry no mark."
        )
    elif suspect.found.marked and not authentic(examine(file.mesh, key), suspect.found.id or 0):
        advice = (
            "The altered parts are back as the marked copy has them; the model does not pass "
            "as signed off, since it was rounded, or marked with other options."
        )
    lost = losses(file.mesh)
    if lost:
        advice += f" Its file cannot keep with other faces: {', '.join(lost)}."
    return Recovery(
        mesh=file.mesh,
        altered_area_fraction=share,
        vertices_moved=file.moved,
        vertices_removed=file.removed,
        faces_added=added,
        advice=advice,
        seconds=perf_counter() - start,
        lost=lost,
        restored_from="marked_copy" if exact else "original",
        intact_rms_over_diagonal=placed.rms if exact else None,
    )
