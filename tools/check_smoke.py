"""Check the facts that must hold in the table of `meshmark bench smoke`: python tools/check_smoke.py RESULTS.csv

A mark that nobody touched is read without an error, also in another frame, order or format; another key reads coin
tosses and finds nothing; nothing is found in models without a mark; the mark keeps to its budget.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from pathlib import Path

from scipy.stats import binomtest

# Payload bits of a row.
BITS = 64
# Chance that coin tosses fail the check.
ALARM = 1e-6
HARMLESS = ("none", "similarity:1", "shuffle:1", "float32:1", "file_obj:1", "midpoint:1")
BUDGETS = {"subtle": 0.0002, "standard": 0.0008, "strong": 0.002}
WRONG_KEYS = 2

Table = list[dict[str, str]]


def violations(table: Table) -> Iterator[str]:
    """Yield a sentence for each fact that does not hold."""
    for row in table:
        if row["status"] != "ok":
            yield f"{named(row)} is {row['status']}: {row['note']}"
    table = [row for row in table if row["status"] == "ok"]
    marked = [row for row in table if row["trial"] == "marked"]
    for attack in HARMLESS:
        rows = [row for row in marked if row["attack"] == attack]
        if not rows:
            yield f"there is no row of a marked model after {attack}"
        for row in rows:
            if (row["present"], row["recovered"], row["ber"]) != ("1", "1", "0.0"):
                yield f"{named(row)} is read with BER {row['ber']}, present {row['present']}, expected 0.0 and 1"
    for row in marked:
        if not 0.0 < float(row["rms_over_diagonal"] or 0) <= BUDGETS[row["budget"]]:
            yield f"{named(row)} moved by {row['rms_over_diagonal']} of the diagonal: nothing, or beyond its budget"
    for trial, least in (("wrong key", WRONG_KEYS), ("unmarked", 1)):
        yield from coin_tosses([row for row in table if row["trial"] == trial], trial, least)


def coin_tosses(rows: Table, trial: str, least: int) -> Iterator[str]:
    """Yield what does not hold where there is nothing to read."""
    if len(rows) < least:
        yield f"there are {len(rows)} rows of the trial '{trial}', expected at least {least}"
        return
    for row in rows:
        if row["present"] != "0":
            yield f"{named(row)} finds a mark, expected none"
    wrong, bits = round(sum(float(row["ber"] or 0) for row in rows) * BITS), BITS * len(rows)
    if binomtest(wrong, bits).pvalue < ALARM:
        yield f"the trial '{trial}' reads {wrong} of {bits} bits wrong, expected about half"


def named(row: dict[str, str]) -> str:
    """Return which case a row is."""
    return (
        f"{row['scheme']}, {row['model']}, {row['budget']}, {row['attack']}, {row['trial']} {row['repeat']}"
    )


def main(path: str) -> int:
    """Print what does not hold; exit code 1 where there is any."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    found = list(violations(table))
    for sentence in found:
        print(f"smoke: {sentence}")
    print(
        f"smoke: {len(table)} rows, {len(found)} facts do not hold"
        if found
        else f"smoke: {len(table)} rows are sound"
    )
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
