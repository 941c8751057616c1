"""A model in a zip archive, as sites for 3D prints serve them: read from it, and written back into it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from meshmark.errors import InputError
from meshmark.io.formats import FORMATS
from meshmark.io.threemf.package import is_3mf
from meshmark.io.wording import amount
from meshmark.io.zip_package import Package, open_package

__all__ = ["Archive", "open_archive"]

# Folders in which macOS keeps what its other files hold beside their content.
_RESOURCES = "__MACOSX"
_USD = (".usd", ".usda", ".usdc", ".usdz")
_MOST_NAMED = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Archive:
    """A zip archive with one model. member: its name there; content: its bytes."""

    package: Package
    member: str
    content: bytes

    @property
    def name(self) -> str:
        """The model's file name, without folders."""
        return PurePosixPath(self.member.replace("\\", "/")).name

    @property
    def others(self) -> int:
        """How many other files there are."""
        return sum(not item.is_dir() for item in self.package.archive.infolist()) - 1

    @property
    def remark(self) -> str:
        """The clause that tells the user."""
        rest = f", beside {amount(self.others, 'other file', 'other files')}" if self.others else ""
        return f"the model in this zip archive is {self.member}{rest}"

    def holding(self, content: bytes) -> bytes:
        """Return the archive with other content for the model, and all else byte for byte."""
        return (
            self.package.data if content == self.content else self.package.with_parts({self.member: content})
        )


def open_archive(data: bytes, path: Path) -> Archive | None:
    """Return the zip archive with its one model, or None where it is a 3MF package.

    Raises `InputError` for a USDZ package, and for an archive without a model or with several, and `FormatError`
    where it cannot be read.
    """
    if path.name.lower().endswith(FORMATS["3mf"].extensions):
        return None
    package = open_package(data, "zip archive")
    if any(name.endswith(_USD) for name in (path.name.lower(), *package.names)):
        raise InputError(f"{path} is a USDZ package, expected one of {_known()}")
    if is_3mf(package):
        return None
    found = [
        item.filename for item in package.archive.infolist() if not item.is_dir() and _is_model(item.filename)
    ]
    if not found:
        raise InputError(f"{path} is a zip archive without a model in it, expected one file of {_known()}")
    if len(found) > 1:
        named = ", ".join(found[:_MOST_NAMED]) + ", ..." * (len(found) > _MOST_NAMED)
        raise InputError(
            f"{path} is a zip archive of {len(found)} models ({named}), expected one: unpack it and give one"
        )
    return Archive(package=package, member=found[0], content=package.read(found[0]))


def _is_model(member: str) -> bool:
    place = PurePosixPath(member.replace("\\", "/"))
    known = any(place.suffix.lower() in entry.extensions for entry in FORMATS.values())
    return known and not place.name.startswith(".") and _RESOURCES not in place.parts


def _known() -> str:
    return " ".join(entry.extensions[0] for entry in FORMATS.values())
