"""What the build of the registry wheel works out: its dependencies, and that an editable one copies no source."""

from __future__ import annotations

from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

NEEDED = ["sqlalchemy>=2.0.36", "alembic>=1.14"]


class RegistryMetadata(MetadataHookInterface):
    """Names the version of the product that this wheel was built with."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the dependencies; the version has been read by then."""
        metadata["dependencies"] = [f"meshmark=={metadata['version']}", *NEEDED]


class NoCopies(BuildHookInterface):
    """In an editable installation ../src is on the path; a copy of the sources beside it would only grow old."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Put nothing but the licence into an editable wheel."""
        if version == "editable":
            home = f"meshmark_registry-{self.metadata.version}.dist-info/LICENSE"
            build_data["force_include_editable"] = {f"{self.root}/../LICENSE": home}
