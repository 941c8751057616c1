"""What a benchmark measures of a model besides schemes: the table of probes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from meshmark.mesh import Mesh
from meshmark.research.ablation.detection_speed import detection_figures
from meshmark.research.ablation.region_maps import region_figures
from meshmark.research.ablation.soft_bits import carrier_figures
from meshmark.research.benchmark.run.job import Outcome, Probe
from meshmark.research.benchmark.run.marked_model import original
from meshmark.research.benchmark.run.seeds import generator_for

__all__ = ["PROBES", "probe"]

PROBES: dict[str, Callable[[Mesh, np.random.Generator], dict[str, Any]]] = {
    "salient points": detection_figures,
    "regions": region_figures,
    "carriers": carrier_figures,
}


def probe(data: Path, job: Probe) -> Outcome:
    """Measure; raises what the probe raises, `CapacityError` where the model has no room for it."""
    rng = generator_for("probe", job.seed, job.kind, job.model)
    mesh = original(data, job.model)
    return Outcome(status="ok", figures=PROBES[job.kind](Mesh(mesh.vertices, mesh.faces), rng))
