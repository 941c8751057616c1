"""What a registry calls the file of a copy that was marked here: by its name, as its place is gone in an hour."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from meshmark.cli.registry_option import open_registry

__all__ = ["register_name"]


def register_name(registry: str, answer: Mapping[str, Any]) -> None:
    """Put the name of a marked file in the place of its path in the folder of a job.

    answer: of `embed`, whose copy is in the registry. Raises `RegistryError` where the registry cannot be written.
    """
    name = Path(answer["outputs"]["model"]).name
    with open_registry(registry) as opened:
        opened.relocate(int(answer["id"], 16), answer["key"], name)
