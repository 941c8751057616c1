"""The models that are measured: in a random order, so that the first few are a fair sample, and marked once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from zlib import crc32

import numpy as np

import meshmark as mm
from claims.models import load, model_paths
from claims.recovery import DONOR
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.marking import Embedding
from meshmark.mesh import Mesh

__all__ = ["KEY", "Subject", "donor", "subjects"]

KEY = mm.Key(bytes(range(32)))
LEAST_POINTS = 2500


@dataclass(frozen=True, eq=False)
class Subject:
    """A model, and what is made of it when it is asked for.

    others: makes another model that is marked with the same key; None: one of the training models.
    """

    name: str
    mesh: Mesh
    others: Callable[[], Mesh] | None = None

    def donor(self) -> Mesh:
        """Return another model, marked with the same key."""
        return donor() if self.others is None else self.others()

    def rng(self, purpose: str) -> np.random.Generator:
        """Return a generator that does not depend on what else is measured."""
        return np.random.default_rng([crc32(self.name.encode()), crc32(purpose.encode())])

    @cached_property
    def surface(self) -> Surface:
        """The model by points."""
        return weld(self.mesh)

    @cached_property
    def diagonal(self) -> float:
        """Of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.mesh.vertices, axis=0)))

    @cached_property
    def marked(self) -> Embedding:
        """Marked as by default."""
        return mm.embed(self.mesh, KEY, id=crc32(self.name.encode()))

    @cached_property
    def upper(self) -> Embedding:
        """Marked with the authentication layer alone, under another id."""
        return mm.embed(self.mesh, KEY, id=1 + crc32(self.name.encode()), layers="authentication")


@cache
def donor() -> Mesh:
    """Return another model, marked with the same key."""
    path = next(path for path in model_paths("models/train") if DONOR in path.name)
    return mm.embed(load(path), KEY, id=77, layers="authentication").mesh


def subjects(folder: str, skip: int, limit: int | None, most_points: int, seed: int) -> Iterator[Subject]:
    """Yield the models of 2,500 to `most_points` points, less the first `skip` of the random order."""
    paths = list(model_paths(folder))
    number = 0
    for place in np.random.default_rng(seed).permutation(len(paths)):
        mesh = load(paths[place])
        subject = Subject(paths[place].name.split(".")[0], mesh)
        if not LEAST_POINTS <= len(subject.surface.points) <= most_points:
            continue
        number += 1
        if number > skip:
            yield subject
        if limit is not None and number == skip + limit:
            return
