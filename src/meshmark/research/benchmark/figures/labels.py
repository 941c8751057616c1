"""Attacks as people read them, and in the order people expect: by kind, mildest first."""

from __future__ import annotations

from meshmark.attacks.table import ATTACKS

__all__ = ["NOTHING", "family", "family_label", "label", "order", "ordered", "steps", "strength_label"]

NOTHING = "none"

# Where the name in the table is not yet how one would say it.
_WORDS = {
    NOTHING: "untouched",
    "gaussian": "Gaussian noise",
    "smoothing": "smoothing 0.1",
    "smoothing_half": "smoothing 0.5",
    "taubin": "Taubin smoothing",
    "midpoint": "midpoint subdivision",
    "loop": "Loop subdivision",
    "sqrt3": "√3 subdivision",
    "float32": "single precision",
    "copy": "copy attack",
    "voxels": "voxel round trip",
}
_LAST = len(ATTACKS)


def steps(attack: str) -> tuple[tuple[str, float | None], ...]:
    """Return the names and strengths of a chain such as "crop:0.1+similarity"; none for "none".

    Reads rows of any origin: names need not be in the table, and a strength that is no number is left out.
    """
    if attack == NOTHING:
        return ()
    return tuple(_step(text) for text in attack.split("+"))


def family(attack: str) -> str | None:
    """Return the name of the attack if the chain is one attack with a strength, else None."""
    parts = steps(attack)
    return parts[0][0] if len(parts) == 1 and parts[0][1] is not None else None


def family_label(name: str) -> str:
    """Return the words for an attack of the table, or of nobody's table."""
    if name.startswith("file_"):
        return f"through {name[5:].upper()}"
    return _WORDS.get(name, name.replace("_", " "))


def strength_label(name: str, strength: float) -> str:
    """Return "0.5 %", "× 30" or "8 bits" for a strength of an attack; "" where there is only one."""
    attack = ATTACKS.get(name)
    unit = attack.unit if attack else ""
    if attack is not None and attack.strengths == (strength,) and strength == 1:
        return ""
    if unit.startswith(("passes", "levels")):
        return f"× {strength:g}"
    if unit.startswith("bits"):
        return f"{strength:g} bits"
    if unit.startswith("models"):
        return f"of {strength:g} copies"
    if unit.startswith("voxels"):
        return f"{strength:g}³"
    if attack is not None and max(attack.strengths) < 1.0:
        return f"{100 * strength:.6g} %"
    return f"{strength:g}"


def label(attack: str) -> str:
    """Return a chain in words: "crop 10 % + noise 0.3 % + similarity"."""
    parts = steps(attack)
    return " + ".join(_label_of_step(*part) for part in parts) or _WORDS[NOTHING]


def order(attack: str) -> tuple[int, int, float, str]:
    """Return a key to sort attacks by: untouched, single ones as in the table mildest first, then chains."""
    parts = steps(attack)
    if not parts:
        return (-1, 0, 0.0, "")
    name, strength = parts[0]
    if len(parts) > 1:
        return (_LAST + 1, len(parts), 0.0, attack)
    place = list(ATTACKS).index(name) if name in ATTACKS else _LAST
    return (place, 0, _harm(name, strength or 0.0), attack)


def ordered(attacks: set[str]) -> list[str]:
    """Return attacks in the order for people."""
    return sorted(attacks, key=order)


def _harm(name: str, strength: float) -> float:
    known = ATTACKS[name].strengths if name in ATTACKS else (strength,)
    return -strength if known[0] > known[-1] else strength


def _step(text: str) -> tuple[str, float | None]:
    name, _, number = text.partition(":")
    try:
        return name, float(number)
    except ValueError:
        return name, None


def _label_of_step(name: str, strength: float | None) -> str:
    number = "" if strength is None else strength_label(name, strength)
    return f"{family_label(name)} {number}".rstrip()
