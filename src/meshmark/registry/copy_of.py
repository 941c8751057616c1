"""The copy of a registry that a suspect is, and the certificate that the registry keeps of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certificate_fields import read_fields
from meshmark.coding.keys import Key
from meshmark.mesh import Mesh
from meshmark.registry.records import Copy
from meshmark.registry.tracing import trace

if TYPE_CHECKING:
    from meshmark.registry.registry import Registry

__all__ = ["certificate_of", "copy_of"]


def certificate_of(id: int, key: Key, registry: Registry) -> Certificate | None:
    """Return the certificate of the copy with an id.

    Parameters
    ----------
    id : int
    key : Key
        With which the copy was marked.
    registry : Registry

    Returns
    -------
    Certificate or None
        None where the registry has no copy with this id, or none that is complete.

    Raises
    ------
    RegistryError
        The registry cannot be read.
    """
    text = registry.certificate(id, key.fingerprint)
    return None if text is None else Certificate(**read_fields(text.encode("utf-8")))


def copy_of(mesh: Mesh, key: Key, registry: Registry) -> Copy | None:
    """Return the copy that a suspect is, whose id is read as `trace` reads it.

    None where no copy of the registry is named, or several are. Raises as `trace` does.
    """
    ids = {each.id for each in trace(mesh, key, registry).matches}
    return registry.copies_with_id(ids.pop(), key.fingerprint)[0] if len(ids) == 1 else None
