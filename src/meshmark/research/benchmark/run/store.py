"""The results of a run in one SQLite file, written as they come; a run that was cut off goes on from it."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from dataclasses import asdict, astuple, fields, replace
from pathlib import Path

from meshmark.errors import InputError, OutputError
from meshmark.io.folder_lock import locked_folder
from meshmark.research.benchmark.run.facts import Facts
from meshmark.research.benchmark.run.job import Job, Look, Mark, Outcome, Probe
from meshmark.research.benchmark.run.row import Case, Row

__all__ = ["NAME", "Store"]

NAME = "results.sqlite"
_CASE = [field.name for field in fields(Case)]
_ROW = [field.name for field in fields(Row) if field.name != "case"]
_FLAGS = {"present", "decoded", "recovered"}
_SCHEMA = f"""
CREATE TABLE IF NOT EXISTS run (start INTEGER PRIMARY KEY, facts TEXT NOT NULL, seconds REAL NOT NULL);
CREATE TABLE IF NOT EXISTS jobs (job TEXT PRIMARY KEY, status TEXT, note TEXT, figures TEXT);
CREATE TABLE IF NOT EXISTS rows ({", ".join(_CASE + _ROW)}, PRIMARY KEY ({", ".join(_CASE)}));
"""
# What two starts of one run have in common.
_SAME = ("suite", "seed", "schemes", "data")


class Store:
    """Rows, finished jobs and the facts of each start; every write is committed before it returns.

    Only the process that holds the store writes to it; another one is refused. Use as a context manager.
    """

    def __init__(self, folder: Path) -> None:
        """Open or make the store of a folder; raises `OutputError` where another run holds it."""
        self.folder, self.path = folder, folder / NAME
        self._lock = locked_folder(folder, "benchmark")
        try:
            self._base = sqlite3.connect(self.path, isolation_level=None)
            self._base.execute("PRAGMA journal_mode=WAL")
            self._base.executescript(_SCHEMA)
            columns = [column[1] for column in self._base.execute("PRAGMA table_info(rows)")]
        except sqlite3.Error as error:
            self._lock.close()
            raise OutputError(f"cannot use {self.path} as a store of results: {error}") from None
        if columns != _CASE + _ROW:
            self.__exit__()
            raise InputError(f"{self.path} was made by another version of meshmark; choose another --out")

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._base.close()
        self._lock.close()

    def begin(self, facts: Facts) -> None:
        """Note a start; raises `InputError` where the store holds another run than this."""
        first = self.facts()
        if first is not None:
            for name in _SAME:
                _check_same(name, getattr(first, name), getattr(facts, name), self.path.parent)
            version = "version of meshmark"
            _check_same(version, first.versions["meshmark"], facts.versions["meshmark"], self.path.parent)
        self._base.execute("INSERT INTO run (facts, seconds) VALUES (?, 0)", [json.dumps(facts.to_dict())])

    def spent(self, seconds: float) -> None:
        """Note the time since the last start."""
        self._base.execute("UPDATE run SET seconds = ? WHERE start = (SELECT max(start) FROM run)", [seconds])

    def facts(self) -> Facts | None:
        """Return the facts of the last start, with the time of all of them; None before the first."""
        starts = self._base.execute("SELECT facts, seconds FROM run ORDER BY start").fetchall()
        if not starts:
            return None
        last = Facts(**json.loads(starts[-1][0]))
        return replace(last, seconds=sum(seconds for _, seconds in starts), starts=len(starts))

    def add_row(self, row: Row) -> None:
        """Keep a row; one of the same case is replaced."""
        values = [*astuple(row.case), *(getattr(row, name) for name in _ROW)]
        places = ", ".join("?" * len(values))
        self._base.execute(f"INSERT OR REPLACE INTO rows VALUES ({places})", values)

    def rows(self) -> list[Row]:
        """Return all rows, in the order of their cases."""
        return sorted(self._rows(), key=lambda row: row.case)

    def _rows(self) -> Iterator[Row]:
        for values in self._base.execute(f"SELECT {', '.join(_CASE + _ROW)} FROM rows"):
            case, figures = Case(*values[: len(_CASE)]), dict(zip(_ROW, values[len(_CASE) :], strict=True))
            flags = {name: bool(figures[name]) for name in _FLAGS if figures[name] is not None}
            yield Row(case=case, **{**figures, **flags})

    def cases(self) -> set[Case]:
        """Return the cases that have a row."""
        return {Case(*values) for values in self._base.execute(f"SELECT {', '.join(_CASE)} FROM rows")}

    def add_job(self, job: Look | Mark | Probe, outcome: Outcome) -> None:
        """Keep what became of a model, a mark or a probe."""
        values = (_name(job), outcome.status, outcome.note, json.dumps(outcome.figures))
        self._base.execute("INSERT OR REPLACE INTO jobs VALUES (?, ?, ?, ?)", values)

    def probes(self) -> dict[Probe, Outcome]:
        """Return what all probes gave, in their order."""
        held = self._base.execute("SELECT job, status, note, figures FROM jobs").fetchall()
        made = ((json.loads(name), status, note, json.loads(text)) for name, status, note, text in held)
        found = {
            Probe(**name["Probe"]): Outcome(status=status, note=note, figures=figures)
            for name, status, note, figures in made
            if "Probe" in name
        }
        return dict(sorted(found.items()))

    def job(self, job: Look | Mark | Probe) -> Outcome | None:
        """Return what became of a model, a mark or a probe, None where it has not been done."""
        found = self._base.execute(
            "SELECT status, note, figures FROM jobs WHERE job = ?", [_name(job)]
        ).fetchone()
        return (
            None if found is None else Outcome(status=found[0], note=found[1], figures=json.loads(found[2]))
        )


def _name(job: Job) -> str:
    return json.dumps({type(job).__name__: asdict(job)}, sort_keys=True)


def _check_same(name: str, held: object, given: object, folder: Path) -> None:
    if held != given:
        raise InputError(
            f"{folder} holds a run with the {name} {_shown(held)}, expected {_shown(given)}; choose another --out"
        )


def _shown(value: object) -> str:
    return ", ".join(value) if isinstance(value, dict) else str(value)
