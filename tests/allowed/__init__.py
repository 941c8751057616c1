"""What is not yet as it should be: lists of offenders, one text file each, that can only become shorter.

A test compares all that it finds with its list. A new offender is a failure; so is an entry that is mended but
still on the list.
"""

from __future__ import annotations

from pathlib import Path


def allowed(name: str) -> list[str]:
    """Return the entries of a list, in the order of the file; lines that begin with # are remarks."""
    lines = Path(__file__).with_name(f"{name}.txt").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]
