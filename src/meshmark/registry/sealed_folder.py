"""A folder of files in which no byte can be changed unseen by whoever has the key.

`manifest.txt` lists every file with its SHA-256, as `sha256sum -c` reads it; `seal.txt` holds the HMAC of the
manifest with a subkey. A folder with a file more, less, or changed is not as it was sealed.
"""

from __future__ import annotations

import hmac
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Final

from meshmark.coding.keys import Key

__all__ = ["MANIFEST", "SEAL", "broken_seal", "sealed_files"]

MANIFEST: Final = "manifest.txt"
SEAL: Final = "seal.txt"
_PURPOSE = "registry proof seal"


def sealed_files(files: Mapping[str, bytes], key: Key) -> dict[str, bytes]:
    """Return files, by their names in the folder ("a/b.ply"), with manifest and seal."""
    lines = [f"{sha256(data).hexdigest()}  {name}\n" for name, data in sorted(files.items())]
    manifest = "".join(lines).encode("utf-8")
    return {**files, MANIFEST: manifest, SEAL: _seal(manifest, key)}


def broken_seal(folder: Path, key: Key) -> str | None:
    """Return why a folder is not as it was sealed with a key, in one sentence; None where it is.

    Raises `OSError` where the folder cannot be read.
    """
    there = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if not path.is_dir()}
    for name in (MANIFEST, SEAL):
        if name not in there:
            return f"{name} is missing"
    manifest = there[MANIFEST].read_bytes()
    if not hmac.compare_digest(there[SEAL].read_bytes(), _seal(manifest, key)):
        return f"{MANIFEST} or {SEAL} was changed, or they were made with another key"
    pairs = (line.split("  ", 1) for line in manifest.decode("utf-8").splitlines())
    listed = {name: digest for digest, name in pairs}
    for name in sorted(listed.keys() | there.keys() - {MANIFEST, SEAL}):
        if name not in there:
            return f"{name} is missing"
        if name not in listed:
            return f"{name} was added"
        if sha256(there[name].read_bytes()).hexdigest() != listed[name]:
            return f"{name} was changed"
    return None


def _seal(manifest: bytes, key: Key) -> bytes:
    return f"{hmac.digest(key.subkey(_PURPOSE), manifest, sha256).hex()}\n".encode("ascii")
