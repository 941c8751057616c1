"""An original as it goes into a registry."""

from __future__ import annotations

from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.registry.original_digest import digest_of_mesh
from meshmark.registry.records import Original
from meshmark.registry.registry import Registry
from meshmark.registry.shape_descriptor import described
from meshmark.registry.times import now

__all__ = ["original_of_mesh"]


def original_of_mesh(mesh: Mesh, name: str, registry: Registry) -> Original:
    """Return what a registry keeps of an unmarked model; its shape is described where it is new to the registry.

    Raises `InputError` where the mesh has no surface.
    """
    digest = digest_of_mesh(mesh)
    known = registry.original(digest)
    if known is not None and known.descriptor is not None:
        return known
    surface = surface_of(mesh)
    return Original(
        digest=digest,
        name=name,
        points=len(surface.points),
        registered_at=now(),
        descriptor=described(surface),
    )
