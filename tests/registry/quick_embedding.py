"""An `embed_file` that writes a file at once, which tells its id alone instead of being a marked model."""

from __future__ import annotations

from dataclasses import replace

from meshmark.marking import Embedding
from tests.marked import marked_pebble

__all__ = ["embed_at_once"]


def embed_at_once(_mesh, out, _key, *, id, staging, **_options) -> Embedding:
    staging.put(out, f"a copy with the id {id:x}".encode())
    made = marked_pebble(40, layers="ownership")
    result = replace(made, id=id)
    result.__dict__["certificate"] = made.certificate
    return result
