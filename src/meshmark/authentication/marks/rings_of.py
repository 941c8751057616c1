"""The rings of a surface's points, walked once for each connectivity and shared by all that ask for them."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from meshmark.authentication.marks.rings import Rings, ordered_rings
from meshmark.geometry.connectivity import Connectivity
from meshmark.geometry.surface import Surface
from meshmark.geometry.winding import consistent_winding

__all__ = ["rings_of"]

_KNOWN: WeakKeyDictionary[Connectivity, list[Rings]] = WeakKeyDictionary()


def rings_of(surface: Surface) -> list[Rings]:
    """Return the rings of a surface (see `ordered_rings`), whose winding is made consistent where it is mixed up.

    Parameters
    ----------
    surface : Surface
        Surfaces that differ in their positions alone share their rings.

    Returns
    -------
    list of Rings
        By size, the same list as long as the connectivity exists; not to be changed.
    """
    connectivity = surface.connectivity
    if connectivity not in _KNOWN:
        faces = consistent_winding(connectivity.faces, connectivity.count)
        _KNOWN[connectivity] = ordered_rings(faces, connectivity.count)
    return _KNOWN[connectivity]
