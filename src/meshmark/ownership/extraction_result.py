"""What an extraction returns; `to_dict` is the JSON of the command line."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from meshmark.coding.chance import band, in_words
from meshmark.coding.elapsed import rounded_up
from meshmark.coding.message import format_id
from meshmark.notebook import notebook_table

__all__ = ["Evidence", "Extraction"]

_DIAGNOSTIC = ("carriers", "carriers_agreeing", "lock_score")


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What one layer of a model says.

    layer: "cells" or "points" (the ownership layer), or "authentication"; id: None where there is a mark that
    carries none, or whose id cannot be read. log10_false_positive: bound on the chance of this without a mark of
    this key. share: of the surface, 0 to 1: what marks of authentication vouch for, what was read of the
    ownership layer.
    """

    layer: str
    id: int | None
    log10_false_positive: float
    share: float = 1.0

    def to_dict(self, *, diagnose: bool = False) -> dict[str, Any]:
        """Return the fields, the id in hexadecimal; the bound in bands and the share rounded unless `diagnose`."""
        identity = None if self.id is None else format_id(self.id)
        bound = self.log10_false_positive
        return {
            "layer": self.layer,
            "id": identity,
            "log10_false_positive": bound if diagnose else band(bound),
            "share": self.share if diagnose else round(self.share, 2),
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class Extraction:
    """What was read from a mesh.

    presence: "present", "absent" or "inconclusive"; id: None where none or several were read; bits: of the id, 64
    or 32; 0 where a mark was read that carries none; None where no word was read.
    ids: all that were read, several of an average of copies, or where parts of the surface carry different ones.
    log10_false_positive: bound on the chance of this answer without a mark of this key, over all that was tried.
    mode: "blind", "certificate", "original" or "registry". carriers: cells, or coordinates of points,
    that were read; carriers_agreeing: those whose bit is the decoded one's.
    lock_score: weighted mean cosine of the phases by which the lattice is locked (`CellKeys`), 1 where all cells
    lie on the quantiser's points, about 0 without a mark.
    advice: one sentence for the reader. evidence: what each layer says of a mark, and of which part of the surface,
    none where it is absent.
    """

    presence: str
    id: int | None
    log10_false_positive: float
    mode: str
    carriers: int
    carriers_agreeing: int
    lock_score: float
    advice: str
    seconds: float
    evidence: tuple[Evidence, ...] = ()
    ids: tuple[int, ...] = ()
    bits: int | None = None

    def _repr_html_(self) -> str:
        present = self.presence == "present"
        return notebook_table(
            self.presence.capitalize(),
            [
                ("Id" if len(self.ids) < 2 else "Ids", ", ".join(format_id(each) for each in self.ids)),
                ("Chance of a false alarm", in_words(band(self.log10_false_positive)) if present else ""),
                ("Read with", self.mode),
                ("Advice", self.advice),
            ],
        )

    def to_dict(self, *, diagnose: bool = False) -> dict[str, Any]:
        """Return the JSON fields, the id in hexadecimal.

        diagnose: with carriers and lock, exact bounds and time, which tell whoever asks often enough how to take
        the mark off; without it the bound is one of `BANDS`, the time one of `SECONDS`.
        """
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        values["id"] = None if self.id is None else format_id(self.id)
        values["ids"] = [format_id(each) for each in self.ids]
        values["evidence"] = [entry.to_dict(diagnose=diagnose) for entry in self.evidence]
        if not diagnose:
            values = {name: value for name, value in values.items() if name not in _DIAGNOSTIC}
            values["log10_false_positive"] = band(self.log10_false_positive)
            values["seconds"] = rounded_up(self.seconds)
        return values
