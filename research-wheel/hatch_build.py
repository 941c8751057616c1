"""Dependencies of the research wheel: the product of the same version, and what research needs beside it."""

from __future__ import annotations

from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

NEEDED = ["pebble>=5.2", "matplotlib>=3.9"]


class ResearchMetadata(MetadataHookInterface):
    """Names the version of the product that this wheel was built with."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the dependencies; the version has been read by then."""
        metadata["dependencies"] = [f"meshmark[attacks]=={metadata['version']}", *NEEDED]
