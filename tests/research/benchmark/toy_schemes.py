"""Schemes in one file outside the package, for tests: a quick one that works, and some that misbehave."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import replace

import numpy as np

from meshmark.errors import CapacityError
from meshmark.research.schemes.scheme import Readout, SharedMark

# Vertices that carry bits stand on a lattice of this step along x; the toy wants models of about unit size.
STEPS = {"subtle": 0.001, "standard": 0.004, "strong": 0.01}
STEP = STEPS["standard"]
SMALLEST = 100


class Toy:
    """Vertex i carries bit i modulo 16: its x coordinate goes to the nearest of two dithered lattices."""

    title, source, bits, blind = "Toy", "tests of meshmark", 16, True

    def embed(self, mesh, bits, key, *, strength="standard"):
        if len(mesh.vertices) < SMALLEST:
            raise CapacityError(f"the model has {len(mesh.vertices)} vertices, needs {SMALLEST}")
        place, dither = self._plan(len(mesh.vertices), key)
        vertices = mesh.vertices.copy()
        target = dither + bits[place] / 2
        vertices[:, 0] = (np.round(vertices[:, 0] / STEP - target) + target) * STEP
        return mesh.with_vertices(vertices)

    def extract(self, mesh, key, *, reference=None):
        time.sleep(float(os.environ.get("TOY_SECONDS", "0")))
        place, dither = self._plan(len(mesh.vertices), key)
        phase = np.cos(2 * np.pi * (mesh.vertices[:, 0] / STEP - dither))
        sums = np.bincount(place, phase, minlength=self.bits)
        counts = np.bincount(place, minlength=self.bits)
        return Readout(
            bits=(sums < 0).astype(np.uint8),
            present=bool(np.abs(sums).sum() > 0.5 * counts.sum()),
            decoded=bool(np.abs(sums).sum() > 0.9 * counts.sum()),
        )

    def _plan(self, count, key):
        random = np.random.default_rng(list(key.subkey("toy")))
        return np.arange(count) % self.bits, random.uniform(size=count)


class Crashing(Toy):
    """Dies of a segmentation fault while reading after a crop."""

    def extract(self, mesh, key, *, reference=None):
        if len(mesh.vertices) % 2:
            os.kill(os.getpid(), signal.SIGSEGV)
        return super().extract(mesh, key)


class Sorting(Toy):
    """Reads the toy's marks where the original tells in which order the vertices were."""

    title, blind, shared_mark = "Sorting", False, SharedMark(scheme="toy", log10_present=-6.0)

    def extract(self, mesh, key, *, reference=None):
        found = self.extract_by_reference(mesh, key, reference=reference)
        return found if found.present else super().extract(mesh, key)

    def extract_by_reference(self, mesh, key, *, reference):
        if len(mesh.vertices) != len(reference.vertices):
            return replace(super().extract(mesh, key), present=False, decoded=False)
        order = np.lexsort(mesh.vertices[:, 1:].T)[np.argsort(np.lexsort(reference.vertices[:, 1:].T))]
        same = np.allclose(mesh.vertices[order][:, 1:], reference.vertices[:, 1:], atol=1e-9)
        found = super().extract(mesh.with_vertices(mesh.vertices[order]), key)
        return found if same else replace(found, present=False, decoded=False)


class Hanging(Toy):
    """Does not come back from its first reading of a model of an odd number of vertices."""

    def extract(self, mesh, key, *, reference=None):
        try:
            if len(mesh.vertices) % 2:
                open(os.environ["TOY_HUNG"], "x").close()  # noqa: PTH123
                time.sleep(3600)
        except FileExistsError:
            pass
        return super().extract(mesh, key)


class Hungry(Toy):
    """Wants 8 TB for a model of an odd number of vertices."""

    def extract(self, mesh, key, *, reference=None):
        if len(mesh.vertices) % 2:
            np.ones(10**12)
        return super().extract(mesh, key)


class Broken(Toy):
    """Raises what no scheme should for a model of an odd number of vertices."""

    def extract(self, mesh, key, *, reference=None):
        if len(mesh.vertices) % 2:
            raise ZeroDivisionError("by\nmistake")
        return super().extract(mesh, key)


class Short(Toy):
    """Reads too few bits."""

    def extract(self, mesh, key, *, reference=None):
        return Readout(bits=np.zeros(3, np.uint8), present=True)


class Informed(Toy):
    """Reads by subtracting the original."""

    blind = False

    def extract(self, mesh, key, *, reference=None):
        assert reference is not None
        found = super().extract(mesh, key)
        return Readout(bits=found.bits, present=not np.array_equal(reference.vertices, mesh.vertices))
