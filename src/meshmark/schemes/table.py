"""The table of schemes: our own, those that other installed packages register, and those of single files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from meshmark.schemes.ncdg_lv.scheme import NcdgLv, NcdgLvCertificate, NcdgLvOriginal
from meshmark.schemes.outside import ENTRY_POINTS, FILE_ENDING, file_digest, load_file, load_point, points
from meshmark.schemes.scheme import Scheme

__all__ = ["ENTRY_POINTS", "SCHEMES", "Schemes"]

OWN: dict[str, Callable[[], Scheme]] = {
    "ncdg_lv": NcdgLv,
    "ncdg_lv_certificate": NcdgLvCertificate,
    "ncdg_lv_original": NcdgLvOriginal,
}


class Schemes(Mapping[str, Scheme]):
    """Schemes by name; one from outside is imported when it is asked for, and never takes the name of ours.

    A name that ends in .py is the path of a file with a scheme in it; such are found, but not listed.
    """

    def __getitem__(self, name: str) -> Scheme:
        if name in OWN:
            return OWN[name]()
        if name.endswith(FILE_ENDING):
            return load_file(name)
        outside = points()
        if name not in outside:
            raise KeyError(f"unknown scheme '{name}', expected one of {', '.join(self)}")
        return load_point(name, outside[name])

    def __iter__(self) -> Iterator[str]:
        yield from OWN
        yield from (name for name in points() if name not in OWN)

    def __len__(self) -> int:
        return len(list(iter(self)))

    def told(self, name: str) -> str:
        """Return title and source of a scheme, of a file also what tells this content of it from another."""
        scheme = self[name]
        content = f", file {file_digest(name)}" if name.endswith(FILE_ENDING) else ""
        return f"{scheme.title} ({scheme.source}{content})"


SCHEMES = Schemes()
