"""Making the certificate of a marked mesh."""

from __future__ import annotations

from typing import Final

from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certificate_fields import packed, unpacked
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.shown import Shown
from meshmark.mesh import Mesh
from meshmark.scene.surfaces import marked_surface, only_repeated

__all__ = ["LANDMARKS", "certify"]

LANDMARKS: Final = 400
"""Largest number of landmarks in a certificate."""


def certify(
    mesh: Mesh, spacing: float, step: float, strength: str, *, repeated_only: bool = False
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
    repeated_only : bool
        The mark lies only in the part of the scene that is shown more than once.

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
    frame = surface.frame
    landmarks = PreparedSurface(surface.points, surface.faces, frame).landmarks(LANDMARKS)
    return Certificate(
        # As the file holds them, so that a certificate is the same after a round trip.
        landmarks=unpacked(packed(landmarks)),
        frame=frame,
        spacing=float(spacing),
        step=float(step),
        strength=strength,
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
    )
