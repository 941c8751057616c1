"""What every attack is given, and the models that it works on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import monotonic

import numpy as np

from claims.models import load, model_paths
from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh

__all__ = ["KEY", "Options"]

KEY = Key(bytes(range(32)))


@dataclass(frozen=True, kw_only=True)
class Options:
    """split: "train" or "test". models, tries: how many, None: as many as the attack's bar asks for. seed: of the
    order of the models and of all that is drawn. least, most: points of a model. end: no model is begun after it.
    """

    split: str = "train"
    models: int | None = None
    tries: int | None = None
    seed: int = 5
    least: int = 2500
    most: int = 20_000
    end: float = float("inf")

    def count(self, asked: int) -> int:
        """Return how many models an attack takes whose bar asks for so many."""
        return asked if self.models is None else self.models

    def rng(self, *purpose: int) -> np.random.Generator:
        """Return a generator that does not depend on what else is drawn."""
        return np.random.default_rng([self.seed, *purpose])

    def meshes(self, *folders: str, least: int | None = None) -> Iterator[tuple[str, Mesh]]:
        """Yield names and models of these folders of the split, each in a random order, until the time is over."""
        for folder in folders or ("models",):
            paths = list(model_paths(f"{folder}/{self.split}"))
            for place in self.rng().permutation(len(paths)):
                if monotonic() > self.end:
                    return
                try:
                    mesh = load(paths[place])
                except MeshmarkError:
                    continue
                if (least or self.least) <= len(surface_of(mesh).points) <= self.most:
                    yield paths[place].name.partition(".")[0], mesh
