"""Train the network of the rival deep3d; needs PyTorch (pip install 'meshmark-research[deep]').

    python tools/train_deep3d.py --data DIR [--data DIR] --out weights.npz [--limit N] [--steps N] [--seed N]

The curve is written beside the weights, as .csv.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from meshmark.errors import MeshmarkError
from meshmark.research.benchmark.run.model_files import choose, find_models, load
from meshmark.research.schemes.rivals.deep3d.examples import Example, example
from meshmark.research.schemes.rivals.deep3d.training_loop import train


def main() -> None:
    """Read the models and train."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, action="append", required=True, help="folder of models")
    parser.add_argument("--out", type=Path, required=True, help="file of weights, .npz")
    parser.add_argument("--limit", type=int, help="largest number of models of each folder")
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    models = list(_examples(given.data, given.limit, np.random.default_rng(given.seed)))
    print(f"{len(models)} models", flush=True)
    train(models, given.steps, given.seed, given.out, given.out.with_suffix(".csv"))


def _examples(folders: Sequence[Path], limit: int | None, rng: np.random.Generator) -> Iterator[Example]:
    """Yield what to train on; models that cannot be read or used are left out."""
    for path in [folder / name for folder in folders for name in choose(folder, find_models(folder), limit)]:
        with suppress(MeshmarkError):
            found = example(load(path), rng)
            if found is not None:
                yield found


if __name__ == "__main__":
    main()
