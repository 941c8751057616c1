"""The table of schemes: our own, those that other installed packages register, and those of single files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from meshmark.research.schemes.ncdg_lv import NcdgLv, NcdgLvCertificate, NcdgLvOriginal
from meshmark.research.schemes.outside import (
    ENTRY_POINTS,
    FILE_ENDING,
    file_digest,
    load_file,
    load_point,
    points,
)
from meshmark.research.schemes.rivals.adf import Adf
from meshmark.research.schemes.rivals.cho import ChoMean, ChoVariance
from meshmark.research.schemes.rivals.deep3d.deep3d import Deep3d
from meshmark.research.schemes.rivals.fcm import Fcm
from meshmark.research.schemes.rivals.laplace_beltrami import LaplaceBeltrami
from meshmark.research.schemes.rivals.lsb import Lsb
from meshmark.research.schemes.rivals.mdaqim import Mdaqim
from meshmark.research.schemes.rivals.spectral import Spectral
from meshmark.research.schemes.rivals.volume_moments import VolumeMoments
from meshmark.research.schemes.scheme import Scheme

__all__ = ["ENTRY_POINTS", "SCHEMES", "Schemes"]

OWN: dict[str, Callable[[], Scheme]] = {
    "ncdg_lv": NcdgLv,
    "ncdg_lv_certificate": NcdgLvCertificate,
    "ncdg_lv_original": NcdgLvOriginal,
    "cho_mean": ChoMean,
    "cho_variance": ChoVariance,
    "laplace_beltrami": LaplaceBeltrami,
    "adf": Adf,
    "mdaqim": Mdaqim,
    "lsb": Lsb,
    "fcm": Fcm,
    "spectral": Spectral,
    "volume_moments": VolumeMoments,
    "deep3d": Deep3d,
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

    def described(self, name: str) -> str:
        """Return title and source of a scheme, what of it is our reconstruction, and of a file its digest."""
        scheme = self[name]
        content = f", file {file_digest(name)}" if name.endswith(FILE_ENDING) else ""
        ours = getattr(scheme, "reconstruction", "")
        return f"{scheme.title} ({scheme.source}{content})" + (
            f" [our reconstruction: {ours}]" if ours else ""
        )


SCHEMES = Schemes()
