"""Check the proof in this folder: python verify.py PROJECT.key

The commitment is opened with Python alone; the seal of the folder and the reading need the package meshmark
(pip install meshmark) and the key of the project. Exit code 0: confirmed; 1: not.
"""

from __future__ import annotations

import json
import sys
from hashlib import sha256
from pathlib import Path

__all__ = ["main"]


def main() -> int:
    """Open the commitment, then let meshmark check the rest."""
    folder = Path(__file__).resolve().parent
    claim = json.loads((folder / "claim.json").read_text("ascii"))
    statement = {"format": "meshmark commitment 1", **claim["statement"]}
    text = json.dumps(statement, sort_keys=True, separators=(",", ":")).encode("ascii")
    commitment = sha256(bytes.fromhex(claim["nonce"]) + text).hexdigest()
    opened = commitment == claim["commitment"]
    print(f"commitment {commitment}: {'opened' if opened else 'NOT what is claimed'}", flush=True)
    if len(sys.argv) != 2:
        print("usage: python verify.py PROJECT.key", file=sys.stderr)
        return 2
    from meshmark.coding.keys import Key
    from meshmark.registry.proof_check import check_proof

    found = check_proof(folder, Key.load(sys.argv[1]))
    print(found.sentence)
    return 0 if found.confirmed and opened else 1


if __name__ == "__main__":
    sys.exit(main())
