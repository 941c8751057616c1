"""What a watermarking scheme is to the benchmark: bits in, bits out.

A scheme of your own is one class with these attributes and methods, registered in your package's metadata:

    [project.entry-points."meshmark.schemes"]
    my_scheme = "my_package.my_module:MyScheme"
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keys import Key
from meshmark.mesh import FloatArray, Mesh

__all__ = ["Bits", "Readout", "Scheme", "SharedMark"]

Bits = NDArray[np.uint8]


@dataclass(frozen=True, eq=False, kw_only=True)
class Readout:
    """What a scheme reads from a mesh.

    bits:    (n,) uint8 best guess of the payload, whatever its quality; chance where there is no mark.
    present: whether the scheme says that a mark of this key is there.
    log10_false_positive: its own bound on being wrong with that, where it has one.
    decoded: whether its error correction says that the payload is right; a mark may be there without that.
    raw:     of a scheme with error correction, what it saw of each code bit before: (c,), positive for 0,
             0 for one it did not see.
    """

    bits: Bits
    present: bool
    log10_false_positive: float | None = None
    decoded: bool = False
    raw: FloatArray | None = field(default=None, repr=False)


@dataclass(frozen=True, kw_only=True)
class SharedMark:
    """That a scheme reads the marks of another, with a reference besides.

    scheme: name of the other, which is blind. log10_present: the bound from which on it says that a mark is there.
    """

    scheme: str
    log10_present: float


@runtime_checkable
class Scheme(Protocol):
    """A watermarking scheme.

    title: name for people; source: where it was published; bits: number of payload bits; blind: whether
    `extract` works without the original (where it does not, it is given one).

    A scheme that is not blind may have `kept(marked, key)`, what an owner keeps of a marked mesh: `extract` is then
    given that as its reference instead of the original.
    A scheme that was built here after a publication may have `reconstruction`, what of it is ours because the
    source does not say; reports show it wherever they name the source.
    A scheme that reads the marks of a blind one may have `shared_mark`, a `SharedMark`, and `extract_by_reference`,
    with the arguments of `extract`, which need not look where the blind one does. A benchmark of both then marks
    once, and asks for the reference only where the blind scheme has decoded nothing; each of the two has half the
    chance of being wrong.
    A scheme whose readouts have `raw` also has `code(bits, key)`, the code bits (c,) that stand for a payload.
    """

    title: str
    source: str
    bits: int
    blind: bool

    def embed(self, mesh: Mesh, bits: Bits, key: Key, *, strength: str = "standard") -> Mesh:
        """Return the mesh carrying the bits, (n,) uint8.

        strength: "subtle", "standard" or "strong": at most 0.02, 0.08 or 0.2 % RMS vertex displacement over the
        bounding-box diagonal. Raises `CapacityError` for a mesh that cannot carry them.
        """
        ...

    def extract(self, mesh: Mesh, key: Key, *, reference: Any = None) -> Readout:
        """Read the bits; `reference` is the unmarked original, or what was kept, for a scheme that is not blind."""
        ...
