"""Making the certificate of a marked mesh."""

from __future__ import annotations

from typing import Final

from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certificate_fields import packed, packed_corners, unpacked
from meshmark.geometry.frame import Frame
from meshmark.geometry.registration.corner_matching import corners_to_keep
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.shown import Shown
from meshmark.mesh import Mesh
from meshmark.scene.surfaces import marked_surface, only_repeated

__all__ = ["LANDMARKS", "NO_LATTICE", "certify"]

LANDMARKS: Final = 400
"""Largest number of landmarks in a certificate."""
NO_LATTICE: Final = "0" * 32
"""The label in a certificate of a model without the ownership layer."""


def certify(
    mesh: Mesh,
    spacing: float,
    step: float,
    strength: str,
    *,
    lattice: str = NO_LATTICE,
    frame: Frame | None = None,
    repeated_only: bool = False,
    at_points: bool = False,
) -> Certificate:
    """Return the certificate of a marked mesh.

    Parameters
    ----------
    mesh : Mesh
    spacing : float
        Of the lattice, in canonical units.
    step : float
        Of the quantisation, in spacings.
    strength : str
        "subtle", "standard" or "strong".
    lattice : str
        Its label, 32 hexadecimal digits; that of a model without the ownership layer by default.
    frame : Frame, optional
        That the mark was made in; by default that of the mesh itself, which the mark may have moved.
    repeated_only : bool
        The mark lies only in the part of the scene that is shown more than once.
    at_points : bool
        The id lies in points, not in cells.

    Returns
    -------
    Certificate

    Raises
    ------
    InputError
        The mesh has no surface.
    """
    surface = marked_surface(mesh)
    if repeated_only and isinstance(surface, Shown):
        surface = next(only_repeated(surface), surface)
    frame = surface.frame if frame is None else frame
    landmarks = PreparedSurface(surface.points, surface.faces, frame).landmarks(LANDMARKS)
    corners = corners_to_keep(frame.to_canonical(surface.points), surface.faces)
    more = {"carriers": "points" if at_points else "cells", "corners": packed_corners(corners)}
    return Certificate(
        # As the file holds them, so that a certificate is the same after a round trip.
        landmarks=unpacked(packed(landmarks)),
        frame=frame,
        lattice=lattice,
        spacing=float(spacing),
        step=float(step),
        strength=strength,
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        more=more,
    )
