"""Authentication, recovery and unmarking, beside the bars they are held to: docs/results/authentication.md.

    python -m claims.authentication BAR... [--folder models/test] [--limit N] [--skip N] [--minutes M]
        [--draws BAR=N ...] [--most-points N] [--seed N] [--rows FILE.csv]

BAR is one of these; all of them without one.
benign     benign operations leave a model authentic; PSNR of the layer alone
edits      local edits are noticed, and where they are
moves      single points moved are noticed
pastes     parts pasted from marked models are noticed
payloads   how much payload there is, when it is read back; an image byte by byte
recovery   error of altered parts after `recover`
unmark     error after `unmark`
forgeries  parts forged without the key; lone marks guessed
roc        the network and the binomial rule at telling touched regions from untouched ones

Models come in a random order, so that the first N are a fair sample. --minutes: no further model is begun after M
minutes. --draws: how many edits of each model (edits, recovery: all 36 without it; roc: 8) or tries (moves,
forgeries: 10,000), drawn at random. --rows: measurements are added to this file, and the table is that of all in
it. Exits 1 where one of the bars that were measured is missed. Below stands what each bar took.
`claims.authenticate_speed` measures the speed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter, process_time

from claims.authentication import benign, forging, payloads, points, ranking, restoring, tampering
from claims.authentication.figures import SECONDS, Row, append, load_rows, table
from claims.authentication.subjects import Subject, subjects
from meshmark.errors import CapacityError

BARS: dict[str, Callable[[Subject, int | None], Iterator[Row]]] = {
    "benign": benign.measure,
    "edits": tampering.measure,
    "moves": points.measure_moves,
    "pastes": tampering.measure_pastes,
    "payloads": payloads.measure,
    "recovery": restoring.measure,
    "unmark": restoring.measure_unmark,
    "forgeries": forging.measure,
    "roc": ranking.measure,
}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("bars", nargs="*", choices=[*BARS, []], metavar="BAR")
    parser.add_argument("--folder", default="models/test")
    parser.add_argument("--limit", type=int)
    parser.add_argument("--skip", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=1e9)
    parser.add_argument("--draws", type=_share, nargs="+", default=[], metavar="BAR=N")
    parser.add_argument("--most-points", type=int, default=10_000_000)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--rows", type=Path)
    options = parser.parse_args()
    start = perf_counter()
    rows: list[Row] = []
    for subject in subjects(options.folder, options.skip, options.limit, options.most_points, options.seed):
        if perf_counter() - start > 60.0 * options.minutes:
            break
        rows += _measured(subject, options.bars or list(BARS), dict(options.draws), options.rows)
    text, met = table(rows if options.rows is None else load_rows(options.rows))
    print(text)
    return int(not met)


def _share(text: str) -> tuple[str, int]:
    bar, _, count = text.partition("=")
    if bar not in BARS:
        raise argparse.ArgumentTypeError(f"'{bar}' is not a bar, expected one of {', '.join(BARS)}")
    return bar, int(count)


def _measured(subject: Subject, bars: list[str], draws: dict[str, int], file: Path | None) -> list[Row]:
    before = process_time()
    layers = subject.marked.layers
    spent = {"marking": process_time() - before}
    print(f"{subject.name}: {len(subject.surface.points)} points, {layers}", flush=True)
    rows: list[Row] = []
    for bar in bars:
        before = process_time()
        found = _of_bar(subject, bar, draws.get(bar))
        spent[bar] = process_time() - before
        print(f"  {bar}: {len(found)} rows, {spent[bar]:.1f} s of processor time", flush=True)
        rows += found
        if file is not None:
            append(found, file)
    costs = [Row(SECONDS, subject.name, bar, seconds) for bar, seconds in spent.items()]
    if file is not None:
        append(costs, file)
    return rows + costs


def _of_bar(subject: Subject, bar: str, draws: int | None) -> list[Row]:
    """Return the rows of a bar; a model that gets no marks of authentication can never be authentic."""
    refused = Row("authentic after a benign operation", subject.name, "no room for the marks", 0.0)
    if subject.marked.layers != "both" and bar != "roc":
        return [refused]
    try:
        return list(BARS[bar](subject, draws))
    except CapacityError as error:
        print(f"  {bar}: {error}")
        return [refused]


if __name__ == "__main__":
    sys.exit(main())
