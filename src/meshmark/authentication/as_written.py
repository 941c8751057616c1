"""What an id alone can say about alteration: its certificate keeps what the file was like when it was written.

Without the authentication layer no mark breaks where a model is changed. Its certificate keeps a keyed digest of
the positions and faces, which proves that nothing was changed, and how well the lattice of the id locked, which
proves a change where it locks worse now than rounding can explain. How much rounding explains is measured on the
suspect: it is rounded at random a few times, as coarsely as any tolerance allows. Where neither is proven, nothing
is said.
"""

from __future__ import annotations

import hmac
from dataclasses import replace
from enum import Enum
from hashlib import blake2b
from math import sqrt

import numpy as np

from meshmark.authentication.marks.precision import precision_of
from meshmark.authentication.written_lock import reader_of
from meshmark.certificate.certificate import Certificate
from meshmark.coding.keyed import keyed_words
from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh

__all__ = ["FIELD", "ROUNDINGS", "WRONG_LOG10", "Since", "since_written", "with_written"]

FIELD = "written"
"""Name of the certificate's field."""
WRONG_LOG10 = -6.0
"""A model that was only rounded is called changed with a probability below 10 to this."""
ROUNDINGS = 16
"""Number of random roundings of a suspect that show how its lock varies."""
_PURPOSE = "positions as written"
_BYTES = 16


class Since(Enum):
    """What is known of a model since it was written."""

    SAME = "same"
    CHANGED = "changed"
    UNKNOWN = "unknown"


def with_written(certificate: Certificate, marked: Mesh, key: Key) -> Certificate:
    """Return the certificate of an id-only model with what `since_written` needs of the marked mesh."""
    lock = reader_of(surface_of(marked), key, certificate).best()
    value = {"positions": _digest(marked, key), "lock": lock.score, "carriers": len(lock.phase)}
    return replace(certificate, more={**certificate.more, FIELD: value})


def since_written(certificate: Certificate, mesh: Mesh, key: Key) -> Since:
    """Return what the certificate of an id-only model, bound to `key`, tells of a suspect.

    SAME: positions and faces are those that were written, to the last bit; CHANGED: the lock dropped by more than
    rounding explains, an error of this answer being less likely than 10^`WRONG_LOG10`.
    """
    value = certificate.more.get(FIELD)
    if not isinstance(value, dict):
        return Since.UNKNOWN
    positions, lock, carriers = (value.get(name) for name in ("positions", "lock", "carriers"))
    if not (isinstance(positions, str) and isinstance(lock, float) and isinstance(carriers, int)):
        return Since.UNKNOWN
    if hmac.compare_digest(positions.encode(), _digest(mesh, key).encode()):
        return Since.SAME
    dropped = carriers > 0 and _dropped(mesh, key, certificate, lock / carriers, carriers)
    return Since.CHANGED if dropped else Since.UNKNOWN


def _dropped(mesh: Mesh, key: Key, certificate: Certificate, written: float, carriers: int) -> bool:
    """Return whether the lock fell from `written` (mean over `carriers` cells) by more than rounding explains.

    Rounding turns the phases of the cells by random angles, so that a share (mean cos of twice the angle) of the
    lock is kept on average; around that the lock of one rounding varies as those of the others do. The limit is
    that of Student's prediction interval for one more observation, the deviation being one cell or more.
    """
    surface = surface_of(mesh)
    reader = reader_of(surface, key, certificate)
    now = reader.best()
    random = np.random.default_rng(keyed_words(key.subkey("roundings of a suspect"), 4))
    from scipy.special import stdtrit

    error = precision_of(mesh, "web")
    kept, locks = [], []
    for _ in range(ROUNDINGS):
        rounded = reader.like(now, surface.points + random.uniform(-error, error, surface.points.shape))
        kept.append(now.agreement(rounded))
        locks.append(rounded.score / carriers)
    deviation = max(float(np.std(locks, ddof=1)), 1.0 / carriers)
    limit = float(-stdtrit(ROUNDINGS - 1, 10.0**WRONG_LOG10)) * sqrt(1.0 + 1.0 / ROUNDINGS)
    return written * float(np.mean(kept)) - now.score / carriers > limit * deviation


def _digest(mesh: Mesh, key: Key) -> str:
    digest = blake2b(digest_size=_BYTES, key=key.subkey(_PURPOSE))
    for array, kind in ((mesh.faces, "<i8"), (mesh.vertices + 0.0, "<f8")):  # -0 is 0
        digest.update(len(array).to_bytes(8, "little") + np.ascontiguousarray(array, kind).tobytes())
    return digest.hexdigest()
