"""Frames of a suspect from a reference, the certificate or the original, where the mark's lattice can be read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.geometry.frame import Frame
from meshmark.geometry.registration.corner_matching import corners_to_keep, match_corners
from meshmark.geometry.registration.landmarks import Landmarks
from meshmark.geometry.registration.prepared_surface import PreparedSurface, prepared_suspect
from meshmark.geometry.registration.register import register
from meshmark.geometry.similarity import Similarity
from meshmark.geometry.surface import Surface
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.scene.surfaces import marked_surface

__all__ = [
    "ORIGINAL_LANDMARKS",
    "corner_frames",
    "frame_of",
    "label_of",
    "registered_frames",
    "starting_frames",
]

# An original may be asked for more landmarks than a certificate holds.
ORIGINAL_LANDMARKS = 500


def registered_frames(
    suspect: Surface, reference: Certificate | Mesh, scales: Sequence[float]
) -> Iterator[Frame]:
    """Yield `corner_frames`, then `starting_frames`: these cost more, and are made when the former did not do."""
    yield from corner_frames(suspect, reference)
    yield from starting_frames(suspect, reference, scales)


def starting_frames(
    suspect: Surface, reference: Certificate | Mesh, scales: Sequence[float] = ()
) -> list[Frame]:
    """Return frames in which the suspect lies as the marked model does in its canonical frame, best first.

    At most five; none where the reference does not fit, or does not determine how (a sphere). Of an unmarked
    original the frame is that of the marked model up to what the mark moved it, 0.1 to 0.3 %.
    scales: as `register` takes them.
    Raises `InputError` where the suspect or the original has no surface.
    """
    landmarks, home = _landmarks(reference)
    found = register(landmarks, home, prepared_suspect(suspect), scales)
    return [frame_of(fit.pose, home) for fit in found]


def _landmarks(reference: Certificate | Mesh) -> tuple[Landmarks, Frame]:
    if isinstance(reference, Certificate):
        return reference.landmarks, reference.frame
    surface = marked_surface(reference)
    home = surface.frame
    return PreparedSurface(surface.points, surface.faces, home).landmarks(ORIGINAL_LANDMARKS), home


def label_of(reference: Certificate | Mesh, key: Key) -> Label:
    """Return the label of the lattice of a mark; the original has the very invariants that it was made from."""
    if isinstance(reference, Certificate):
        return Label.of_hex(reference.lattice)
    return Label.of_shape(marked_surface(reference).invariants, key)


def corner_frames(suspect: Surface, reference: Certificate | Mesh) -> list[Frame]:
    """Return exact frames, as `starting_frames` does, from triangles that the suspect still has; at most five."""
    if isinstance(reference, Certificate):
        corners, home = reference.corners, reference.frame
    else:
        original = marked_surface(reference)
        home = original.frame
        corners = corners_to_keep(home.to_canonical(original.points), original.faces)
    return [frame_of(fit, home) for fit in match_corners(corners, suspect.points, suspect.faces)]


def frame_of(pose: Similarity, home: Frame) -> Frame:
    """Return the frame of the suspect, given how canonical coordinates lie in its scene."""
    return replace(home, centre=pose.shift, scale=pose.scale, axes=pose.rotation)
