"""Where a report comes from: the file it is about, the key, the date, and the programs that made it."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from meshmark import __version__
from meshmark.io.file_digest import digest_of_file

__all__ = ["Provenance", "provenance"]


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """name: of the file that a report is about. files: name and SHA-256 in hexadecimal of each that it consists
    of, the model first; none where it came from standard input. key: its public fingerprint. reference: what
    helped to read the mark, with its name; empty for the key alone. made: when, in UTC.
    """

    name: str
    files: tuple[tuple[str, str], ...]
    key: str
    reference: str
    made: datetime

    def rows(self) -> list[tuple[str, str]]:
        """Return terms and texts for a table."""
        import numpy
        import scipy

        rows = [("File", self.name)]
        if self.files:
            rows += [
                ("SHA-256", self.files[0][1]),
                *((f"SHA-256 of {name}", sha) for name, sha in self.files[1:]),
            ]
        else:
            rows += [("SHA-256", "none: the model came from standard input")]
        rows += [
            ("Date", f"{self.made:%d %B %Y, %H:%M} UTC".lstrip("0")),
            ("Key", f"{self.key} (public fingerprint)"),
            ("Read with", self.reference or "the key alone"),
            (
                "Made by",
                f"meshmark {__version__}, Python {platform.python_version()}, numpy {numpy.__version__}, "
                f"scipy {scipy.__version__}",
            ),
        ]
        return rows


def provenance(
    name: str,
    files: Mapping[str, Path],
    key: str,
    reference: str = "",
    made: datetime | None = None,
) -> Provenance:
    """Return the provenance of a report about a file.

    files: that it consists of, by name, the model first; those that do not exist, as standard input, are left out.
    key: public fingerprint. made: now by default.
    """
    sums = tuple((called, digest_of_file(path)) for called, path in files.items() if path.is_file())
    return Provenance(name=name, files=sums, key=key, reference=reference, made=made or datetime.now(UTC))
