"""Are marks found in compressed copies, are these decoded to the last bit, and does a broken stream do no harm?

Run: python -m claims.compressed_gltf FOLDER --node NODE
    [--store FOLDER] [--count 60] [--forms FORM ...] [--hostile 5]

FOLDER holds GLBs, in any depth. They are tried in the order of the SHA-256 of their bytes, equal files once, and
marked with the default options, until `count` are marked; those refused are counted. Each marked file is
compressed by common tools in each of the forms; of each form the table says in how many files the id was found, and
in how many every index and attribute is what the reference decoders give. From each compressed file broken ones are
made, `hostile` of each kind; what reading them does is counted, its time and memory measured.

NODE is a folder after `npm install --prefix NODE @gltf-transform/cli@4.5 gltfpack meshoptimizer draco3dgltf`.
Interrupted? Run it again: what the store has is not repeated. Exit code 1 where an id is missed, a bit differs, a
tool makes no copy, fewer than `count` models can be marked, or a broken file crashes, takes over 30 s or over 1 GB.

Figures of docs/decisions/0002-compressed-gltf.md.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from claims.compressed_gltf.copies import FORMS, copy_path, measure_copies, table
from claims.compressed_gltf.hostile import harmful, measure_hostile, summary
from claims.compressed_gltf.models import marked_models


def main() -> int:
    """Print the refusals, the table of forms and that of broken files."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--node", type=Path, required=True)
    parser.add_argument(
        "--store", type=Path, default=Path("compressed_gltf"), help="where files and rows are kept"
    )
    parser.add_argument("--count", type=int, default=60, help="how many models are marked")
    parser.add_argument("--forms", nargs="+", choices=FORMS, default=list(FORMS), metavar="FORM")
    parser.add_argument(
        "--hostile", type=int, default=5, help="broken files of each kind per compressed file"
    )
    given = parser.parse_args()
    given.store.mkdir(parents=True, exist_ok=True)
    tried = marked_models(given.folder, given.store, given.count)
    models = [row for row in tried if not row.refused]
    copies = measure_copies(models, given.forms, given.node.resolve(), given.store)
    files = [copy_path(given.store, row.digest, row.form) for row in copies if row.made]
    hostile = measure_hostile(files, given.hostile, given.store)
    for reason in ("capacity", "other"):
        refused = [row for row in tried if row.refused == reason]
        print(f"refused for {reason if reason == 'capacity' else 'other reasons'}: {len(refused)}")
        print("".join(f"  {row.name}: {row.message}\n" for row in refused), end="")
    print(f"models: {len(models)} marked of {len(tried)} tried")
    print(table(copies))
    print(summary(hostile))
    whole = len(models) == given.count and all(row.made and row.equal and row.found for row in copies)
    return int(not whole or any(map(harmful, hostile)))


if __name__ == "__main__":
    sys.exit(main())
