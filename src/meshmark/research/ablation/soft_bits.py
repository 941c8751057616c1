"""What the extraction network is worth: soft bits of attacked models, by the network and by the plain rule."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from meshmark.errors import CapacityError
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.research.ablation.extraction_rules import EXTRACTIONS
from meshmark.research.training.demodulator_training import information, raw_errors
from meshmark.research.training.demodulator_trials import Marked, Trial, mark, trials

__all__ = ["carrier_figures"]

ATTACKS: Final = (("noise", 0.005), ("smoothing", 10.0))
# Ids are also read from this share of the carriers, as if the mark had that share of its energy.
SHARE: Final = 0.5


def carrier_figures(mesh: Mesh, rng: np.random.Generator) -> dict[str, Any]:
    """Return for "network" and "rule" lists with an entry for each reading after a lock that succeeded.

    errors: share of wrong signs; information: bits per carrier; decoded, decoded_half: whether the id comes back
    from all and from half of the carriers. Raises `CapacityError` for a model whose cells have no room for
    a mark.
    """
    marked = mark(mesh, rng)
    if marked is None:
        raise CapacityError("the cells of the model have no room for a mark")
    figures: dict[str, dict[str, list[float]]] = {
        name: {"errors": [], "information": [], "decoded": [], "decoded_half": []} for name in EXTRACTIONS
    }
    for trial in trials(marked, rng, ATTACKS):
        order = rng.permutation(len(trial.seen))
        for name, extraction in EXTRACTIONS.items():
            soft = extraction.bits(trial)
            figures[name]["errors"].append(raw_errors(soft, trial.targets))
            figures[name]["information"].append(information(soft, trial.targets))
            figures[name]["decoded"].append(_decoded(marked, trial, soft, 1.0, order))
            figures[name]["decoded_half"].append(_decoded(marked, trial, soft, SHARE, order))
    return figures


def _decoded(marked: Marked, trial: Trial, soft: FloatArray, share: float, order: IntArray) -> float:
    keep = order[: int(share * len(order))]
    values = np.bincount(trial.seen.keys.code_index[keep], soft[keep], marked.codec.n).astype(np.float64)
    return float(marked.codec.decode(values).id == marked.identity)
