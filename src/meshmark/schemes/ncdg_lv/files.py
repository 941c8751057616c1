"""From a file to a marked file that was read back before it took its name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.io import read_mesh, write_mesh
from meshmark.schemes.ncdg_lv.embedding import embed
from meshmark.schemes.ncdg_lv.extraction import extract
from meshmark.schemes.ncdg_lv.results import Embedding

__all__ = ["embed_file"]


def embed_file(
    model: str | Path,
    out: str | Path,
    key: Key,
    id: int | None = None,
    strength: str = "standard",
    layers: str = "ownership",
) -> Embedding:
    """Mark the model file `model` and write the result to `out`; see `embed` for the arguments.

    The complete files are written under temporary names, read again and extracted blind; only then do they
    take their places; `seconds` counts all of it. Raises what reading, embedding and writing raise, and
    `CapacityError` where the id is not found in the written file (a target format too coarse for the mark);
    nothing is left behind then.
    """
    start = perf_counter()
    mesh = read_mesh(model)
    result = embed(mesh, key, id=id, strength=strength, layers=layers)

    def read_back(written: Path) -> None:
        if extract(read_mesh(written), key).id != result.id:
            raise CapacityError(
                f"the id cannot be read back from {Path(out).name}, whose format holds positions too coarsely; "
                "use --strength strong or the format of the input"
            )

    report = write_mesh(result.mesh, out, verify=read_back)
    remarks: tuple[str, ...] = ()
    if report.dropped:
        remarks = (f"{Path(out).name} cannot hold the model's {', '.join(report.dropped)}",)
    return replace(result, seconds=perf_counter() - start, remarks=remarks)
