"""The table of schemes: our own, and those that other installed packages register."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points

from meshmark.errors import InputError
from meshmark.schemes.ncdg_lv.scheme import NcdgLv, NcdgLvCertificate, NcdgLvOriginal
from meshmark.schemes.scheme import Scheme

__all__ = ["ENTRY_POINTS", "SCHEMES", "Schemes"]

# The group of entry points under which a package offers schemes.
ENTRY_POINTS = "meshmark.schemes"

OWN: dict[str, Callable[[], Scheme]] = {
    "ncdg_lv": NcdgLv,
    "ncdg_lv_certificate": NcdgLvCertificate,
    "ncdg_lv_original": NcdgLvOriginal,
}


class Schemes(Mapping[str, Scheme]):
    """Schemes by name; one from outside is imported when it is asked for, and never takes the name of ours."""

    def __getitem__(self, name: str) -> Scheme:
        if name in OWN:
            return OWN[name]()
        outside = _outside()
        if name not in outside:
            raise KeyError(f"unknown scheme '{name}', expected one of {', '.join(self)}")
        return _load(name, outside[name])

    def __iter__(self) -> Iterator[str]:
        yield from OWN
        yield from (name for name in _outside() if name not in OWN)

    def __len__(self) -> int:
        return len(list(iter(self)))


SCHEMES = Schemes()


def _outside() -> dict[str, EntryPoint]:
    return {point.name: point for point in sorted(entry_points(group=ENTRY_POINTS), key=lambda p: p.name)}


def _load(name: str, point: EntryPoint) -> Scheme:
    scheme = point.load()()
    if not isinstance(scheme, Scheme):
        missing = [
            part
            for part in ("title", "source", "bits", "blind", "embed", "extract")
            if not hasattr(scheme, part)
        ]
        raise InputError(f"scheme '{name}' ({point.value}) lacks {', '.join(missing)}")
    return scheme
