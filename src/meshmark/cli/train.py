"""`meshmark train`: train the demodulator's network on a folder of models."""

from __future__ import annotations

import shlex
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.options import AsJson
from meshmark.cli.output import answer, plural
from meshmark.cli.paths import check_output
from meshmark.cli.progress import counted
from meshmark.errors import InputError, MeshmarkError

if TYPE_CHECKING:
    from meshmark.schemes.ncdg_lv.trials import Trial

__all__ = ["train"]


def train(
    data: Annotated[Path, typer.Option(metavar="DIR", help="Folder of models to mark, attack and read.")],
    out: Annotated[Path, typer.Option(metavar="OUT.json", help="File to write the network to.")],
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Start of the random numbers.")] = 0,
    limit: Annotated[int | None, typer.Option(min=2, metavar="N", help="Use only so many models.")] = None,
    most_points: Annotated[
        int, typer.Option(min=1, metavar="N", help="Leave out models of more vertices.")
    ] = 20_000,
    as_json: AsJson = False,
) -> int:
    """Train the network that weighs what is read of a mark.

    Every model of DIR is marked and attacked; a third of the models is kept aside to say when to stop.
    """
    from meshmark.network.weights import dump_network
    from meshmark.schemes.ncdg_lv.features import FEATURES
    from meshmark.schemes.ncdg_lv.training import train_demodulator

    start = perf_counter()
    check_output(out, [data], ".json")
    models = _trials(data, seed, limit, most_points)
    trained = train_demodulator(models, seed)
    command = f"meshmark train --data {shlex.quote(str(data))} --out {out.name} --seed {seed}"
    command += f" --limit {limit}" if limit is not None else ""
    command += f" --most-points {most_points}"
    notes = {"command": command, **trained.notes}
    _write(out, dump_network(trained.network, FEATURES, notes))
    figures = trained.notes["figures on validation models"]["all"]
    words = (
        f"Trained: {out}; {plural(len([name for name in models if models[name]]), 'model')}; on those kept aside "
        f"{100 * figures['errors network']:.2f} % wrong signs (nearest point: "
        f"{100 * figures['errors nearest point']:.2f} %), {figures['bits network']:.3f} bits per place "
        f"(cosine: {figures['bits cosine']:.3f})"
    )
    answer(words, {"out": str(out), **notes, "seconds": perf_counter() - start}, as_json)
    return 0


def _write(out: Path, text: str) -> None:
    from meshmark.io.whole import write_whole

    write_whole(out, text.encode("utf-8"))


def _trials(data: Path, seed: int, limit: int | None, most_points: int) -> dict[str, list[Trial]]:
    """Return the trials of each model; one that cannot be read or marked has none."""
    import numpy as np

    from meshmark.benchmark.models import choose, find_models, load
    from meshmark.schemes.ncdg_lv.trials import mark, trials

    names = choose(data, find_models(data), limit)
    result: dict[str, list[Trial]] = {}
    with counted("models") as told:
        for number, name in enumerate(names):
            rng = np.random.default_rng([seed, number])
            result[name] = []
            with suppress(MeshmarkError):
                mesh = load(data / name)
                marked = mark(mesh, rng) if len(mesh.vertices) <= most_points else None
                result[name] = list(trials(marked, rng)) if marked else []
            told(number + 1, len(names), sum(not found for found in result.values()))
    if not any(result.values()):
        raise InputError(f"{data}: no model could be marked and read, expected at least 2")
    return result
