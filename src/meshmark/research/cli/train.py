"""`meshmark train`: train one of the two networks on a folder of models."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from meshmark.cli.options import AsJson, Force
from meshmark.cli.output import answer, described, plural
from meshmark.cli.paths import staged
from meshmark.cli.progress import counted
from meshmark.errors import InputError, MeshmarkError

if TYPE_CHECKING:
    import numpy as np

    from meshmark.mesh import Mesh
    from meshmark.network.perceptron import Perceptron
    from meshmark.research.training.demodulator_trials import Trial
    from meshmark.research.training.region_trials import RegionTrial

__all__ = ["train"]

# Local edits of each model.
_EDITS = 8
_Made = TypeVar("_Made")


class Network(StrEnum):
    """What to train."""

    demodulator = "demodulator"
    distortion = "distortion"


def train(
    data: Annotated[Path, typer.Option(metavar="DIR", help="Folder of models to mark, attack and read.")],
    out: Annotated[Path, typer.Option(metavar="OUT.json", help="File to write the network to.")],
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Start of the random numbers.")] = 0,
    network: Annotated[
        Network,
        typer.Option(help="demodulator: weighs what is read of an id; distortion: judges a model's regions."),
    ] = Network.demodulator,
    limit: Annotated[int | None, typer.Option(min=2, metavar="N", help="Use only N models.")] = None,
    most_points: Annotated[
        int, typer.Option(min=1, metavar="N", help="Leave out models of more vertices.")
    ] = 20_000,
    force: Force = False,
    as_json: AsJson = False,
) -> int:
    """Train one of the networks: demodulator or distortion.

    Every model of DIR is marked and attacked; some of the models are kept aside to say when to stop.
    """
    from meshmark.network.weights import dump_network

    start = perf_counter()
    staging = staged([(out, ".json")], [data], force)
    made = _demodulator if network is Network.demodulator else _distortion
    trained, features, notes, words = made(data, seed, limit, most_points)
    command = f"meshmark train --data {shlex.quote(str(data))} --out {out.name} --seed {seed}"
    command += f" --network {network.value}" if network is not Network.demodulator else ""
    command += f" --limit {limit}" if limit is not None else ""
    command += f" --most-points {most_points}"
    notes = {"command": command, **notes}
    with staging:
        staging.put(out, dump_network(trained, features, notes).encode("utf-8"))
    fields = {"out": str(out), **notes, "seconds": perf_counter() - start}
    answer(f"Trained: {out}; {words}", described(fields, data, {"network": out}), as_json)
    return 0


_Trained = tuple["Perceptron", tuple[str, ...], dict[str, Any], str]


def _demodulator(data: Path, seed: int, limit: int | None, most_points: int) -> _Trained:
    from meshmark.ownership.carrier_features import FEATURES
    from meshmark.research.training.demodulator_training import train_demodulator
    from meshmark.research.training.demodulator_trials import mark, trials

    def made(mesh: Mesh, rng: np.random.Generator) -> list[Trial]:
        marked = mark(mesh, rng)
        return list(trials(marked, rng)) if marked else []

    models = _trials(data, seed, limit, most_points, made)
    trained = train_demodulator(models, seed)
    figures = trained.notes["figures on validation models"]["all"]
    words = (
        f"{plural(_used(models), 'model')}; on those kept aside "
        f"{100 * figures['errors network']:.2f} % wrong signs (nearest point: "
        f"{100 * figures['errors nearest point']:.2f} %), {figures['bits network']:.3f} bits per place "
        f"(cosine: {figures['bits cosine']:.3f})"
    )
    return trained.network, FEATURES, trained.notes, words


def _distortion(data: Path, seed: int, limit: int | None, most_points: int) -> _Trained:
    from meshmark.authentication.regions.region_evidence import FEATURES
    from meshmark.research.training.region_training import train_classifier
    from meshmark.research.training.region_trials import region_trials

    def made(mesh: Mesh, rng: np.random.Generator) -> list[RegionTrial]:
        return list(region_trials(mesh, rng, _EDITS))

    models = _trials(data, seed, limit, most_points, made)
    trained = train_classifier(models, seed)
    rule, network = trained.notes["area under the curve, validation, rule and network"]
    words = (
        f"{plural(_used(models), 'model')}; on those kept aside an area under the curve of {network:.4f} "
        f"(binomial rule: {rule:.4f})"
    )
    return trained.network, FEATURES, trained.notes, words


def _used(models: dict[str, list[Any]]) -> int:
    return sum(bool(found) for found in models.values())


def _trials(
    data: Path,
    seed: int,
    limit: int | None,
    most_points: int,
    made: Callable[[Mesh, np.random.Generator], list[_Made]],
) -> dict[str, list[_Made]]:
    """Return the trials of each model; one that cannot be read or marked has none."""
    import numpy as np

    from meshmark.research.benchmark.run.model_files import choose, find_models, load

    names = choose(data, find_models(data), limit)
    result: dict[str, list[_Made]] = {}
    with counted("models") as progress:
        for number, name in enumerate(names):
            rng = np.random.default_rng([seed, number])
            result[name] = []
            with suppress(MeshmarkError):
                mesh = load(data / name)
                result[name] = made(mesh, rng) if len(mesh.vertices) <= most_points else []
            progress(number + 1, len(names), sum(not found for found in result.values()))
    if not any(result.values()):
        raise InputError(f"{data}: no model could be marked and read, expected at least 2")
    return result
