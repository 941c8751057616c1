"""A batch from its options: what is checked before any work, the processes or the cluster, and the summary."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter

from meshmark.batch.results import RESULTS, Results, Row, error_kind
from meshmark.batch.running import Executor, run
from meshmark.batch.sources import Item, items
from meshmark.cli.batch_job import CERTIFICATE_SUFFIX, BatchCommand, done
from meshmark.cli.output import plural, say
from meshmark.cli.paths import make_folder
from meshmark.cli.progress import counted
from meshmark.errors import InputError, OutputError
from meshmark.io.atomic_write import write_whole

__all__ = ["SUMMARY", "BatchOptions", "run_batch"]

SUMMARY = "summary.json"
# What a worker imports before its first model.
_NEEDED = {
    "embed": "meshmark.marking.marked_file",
    "extract": "meshmark.marking.both_layers_extraction",
    "authenticate": "meshmark.authentication.verdict",
    "trace": "meshmark.marking.both_layers_extraction",
}


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """Options that all commands of a batch have; `cli.batch_commands` says what each is."""

    source: str
    workers: int | None
    scheduler: str | None
    resume: bool
    seconds: float
    memory_mb: int
    json_lines: bool
    force: bool


def run_batch(command: BatchCommand, options: BatchOptions) -> int:
    """Do it, and return the exit code: 1 where a model has an error instead of an answer."""
    from meshmark.coding.keys import Key

    start = perf_counter()
    if options.workers is not None and options.scheduler is not None:
        raise InputError("--workers and --scheduler exclude each other, expected one of them")
    Key.load(command.key, force=options.force)
    out = Path(command.out)
    make_folder(out)
    with Results(out, resume=options.resume) as results:
        if options.resume:
            _remove_temporary(out)
        total = _checked(command, options, results)
        with _executor(command, options) as executor, counted("models") as report:
            failed = [0]
            run(
                _models(command, options),
                executor,
                results,
                _reporter(results, total, failed, options, report),
            )
        counts = results.counts()
    seconds = perf_counter() - start
    summary = {
        "command": command.name,
        "models": total,
        "outcomes": dict(sorted(counts.items())),
        "seconds": seconds,
    }
    write_whole(out / SUMMARY, f"{json.dumps(summary, indent=1)}\n".encode())
    words = ", ".join(f"{count:,} {name}" for name, count in sorted(counts.items()))
    line = f"{plural(total, 'model')}: {words or 'nothing to do'}. Results: {out / RESULTS}"
    say(line) if options.json_lines else print(line)
    return int(any(name.startswith("failed") for name in counts))


def _models(command: BatchCommand, options: BatchOptions) -> Iterator[Item]:
    return items(options.source, Path(command.out))


def _reporter(
    results: Results,
    total: int,
    failed: list[int],
    options: BatchOptions,
    report: Callable[[int, int, int], None],
) -> Callable[[Row], None]:
    """Return what is called with each new row."""

    def tell(row: Row) -> None:
        failed[0] += error_kind(row) is not None
        report(len(results.done), total, failed[0])
        if options.json_lines:
            print(json.dumps(row, allow_nan=False), flush=True)

    return tell


def _checked(command: BatchCommand, options: BatchOptions, results: Results) -> int:
    """Return how many models there are; raises `InputError` and `OutputError` before any work is done."""
    names: set[str] = set()
    for item in _models(command, options):
        if item.name in names:
            raise InputError(f"{options.source} names {item.name} twice, expected each model once")
        names.add(item.name)
        if command.name == "embed":
            _check_place(command, options, item)
    if not names:
        raise InputError(f"there is no model in {options.source}")
    unknown = results.done - names
    if unknown:
        raise InputError(
            f"{results.path} has a row of {min(unknown)}, which is not in {options.source}; expected the source "
            "that was begun with"
        )
    return len(names)


def _check_place(command: BatchCommand, options: BatchOptions, item: Item) -> None:
    place = command.marked(item)
    if os.path.realpath(place) == os.path.realpath(item.path):
        raise OutputError(
            f"{place} is also an input, which is never overwritten; expected another OUT", file=place
        )
    for path in (place, Path(f"{place}{CERTIFICATE_SUFFIX}")) if command.certificates else (place,):
        if not (options.resume or options.force) and os.path.lexists(path):
            raise OutputError(
                f"{path} exists already, expected another folder, or --force to replace it", file=path
            )


def _remove_temporary(out: Path) -> None:
    """Remove what a run that was killed left under temporary names."""
    from meshmark.io.staging import TEMPORARY

    for left in out.rglob(TEMPORARY):
        shutil.rmtree(left, ignore_errors=True)


@contextmanager
def _executor(command: BatchCommand, options: BatchOptions) -> Iterator[Executor]:
    with ExitStack() as stack:
        if options.scheduler is not None:
            from meshmark.batch.cluster import Cluster
            from meshmark.cli.batch_child import in_child

            work = partial(in_child, command, options.seconds, options.memory_mb)
            yield stack.enter_context(Cluster(options.scheduler, work))
            return
        from meshmark.workers.worker_pool import WorkerPool

        pool: WorkerPool[Item, Row] = WorkerPool(
            options.workers or _cores(),
            partial(done, command),
            time_limit=options.seconds,
            memory_mb=options.memory_mb,
            preload=_NEEDED[command.name],
        )
        yield stack.enter_context(pool)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
