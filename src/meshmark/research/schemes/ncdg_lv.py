"""NCDG-LV as the benchmark sees it: 64 bits in, 64 bits out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshmark.certificate.certificate import Certificate
from meshmark.certificate.certify import certify
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, bits_of
from meshmark.errors import InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.ownership.decoding import Found
from meshmark.ownership.embedding import embed
from meshmark.ownership.extraction import find
from meshmark.ownership.parameters import PRESENT_LOG10
from meshmark.ownership.search.search import Search
from meshmark.research.schemes.scheme import Bits, Readout, SharedMark
from meshmark.threads import on_one_thread

__all__ = ["NcdgLv", "NcdgLvCertificate", "NcdgLvOriginal"]


class NcdgLv:
    """The ownership layer of NCDG-LV; the payload is the 64-bit id, most significant bit first."""

    title = "NCDG-LV"
    source = "NCDG-LV, ownership layer (docs/design.md, section 4)"
    bits = ID_BITS
    blind = True
    effort = "quick"
    """Of the search, one of `EFFORTS`."""

    def embed(self, mesh: Mesh, bits: Bits, key: Key, *, strength: str = "standard") -> Mesh:
        """See `Scheme.embed`; the mark has been read back when this returns."""
        return embed(mesh, key, id=_to_id(bits), strength=strength).mesh

    @on_one_thread
    def extract(self, mesh: Mesh, key: Key, *, reference: Mesh | Certificate | None = None) -> Readout:
        """See `Scheme.extract`; blind, the reference is not looked at."""
        known = None if self.blind else reference
        return _readout(find(Search(surface=weld(mesh), key=key, effort=self.effort, reference=known)), key)

    def code(self, bits: Bits, key: Key) -> Bits:
        """Return the code bits (4096,) that stand for a payload (64,)."""
        return Codec(key).encode(_to_id(bits))


class NcdgLvOriginal(NcdgLv):
    """The same mark, read by an owner who kept the unmarked original."""

    title = "NCDG-LV with the original"
    source = "NCDG-LV, ownership layer (docs/design.md, section 6)"
    blind = False
    shared_mark = SharedMark(scheme="ncdg_lv", log10_present=PRESENT_LOG10)

    @on_one_thread
    def extract_by_reference(self, mesh: Mesh, key: Key, *, reference: Mesh | Certificate) -> Readout:
        """Read by those strategies that need the reference, and no others."""
        search = Search(surface=weld(mesh), key=key, effort=self.effort, reference=reference)
        blind = replace(search, reference=None)
        return _readout(find(search, lambda each: each.by_reference or not each.applies(blind)), key)


class NcdgLvCertificate(NcdgLvOriginal):
    """The same mark, read by an owner who kept the certificate."""

    title = "NCDG-LV with the certificate"

    @on_one_thread
    def kept(self, marked: Mesh, key: Key) -> Certificate:
        """Return the certificate of a marked model, its lattice being the one it is read with."""
        reading = find(Search(surface=weld(marked), key=key, effort="plain")).reading
        if reading is None:
            raise InputError("the marked model has too few carriers to certify")
        return certify(
            marked,
            reading.spacing,
            reading.step,
            "standard",
            lattice=str(reading.label),
            at_points=reading.at_points,
        )


def _readout(found: Found, key: Key) -> Readout:
    if found.reading is None:
        return Readout(bits=_to_bits(0), present=False, log10_false_positive=0.0, raw=np.zeros(Codec(key).n))
    observed = found.reading.observed()
    identity = found.id
    if identity is None or bits_of(identity) != ID_BITS:
        identity = Codec(key).decode(observed).guess
    return Readout(
        bits=_to_bits(identity),
        present=found.present,
        log10_false_positive=found.log10_false_positive,
        decoded=found.id == identity,
        raw=observed,
    )


def _to_id(bits: Bits) -> int:
    if np.shape(bits) != (ID_BITS,):
        raise InputError(f"the payload has shape {np.shape(bits)}, expected ({ID_BITS},)")
    return int.from_bytes(np.packbits(bits).tobytes(), "big")


def _to_bits(identity: int) -> Bits:
    return np.unpackbits(np.frombuffer(identity.to_bytes(ID_BITS // 8, "big"), dtype=np.uint8))
