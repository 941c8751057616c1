"""The strengths of a mark: how far it may move the surface."""

from __future__ import annotations

from typing import Final

from meshmark.errors import InputError

__all__ = ["BUDGETS", "SHOWN_SHARES", "VISIBLE_SHARES", "check_strength"]

# Largest RMS displacement of all layers together, over the bounding-box diagonal.
BUDGETS: Final = {"subtle": 2e-4, "standard": 8e-4, "strong": 2e-3}
# Share of the surface where the mark of ownership is visible (`geometry.visibility`) at most, about.
VISIBLE_SHARES: Final = {"subtle": 0.003, "standard": 0.025, "strong": 0.2}

# Share above which marks of both layers give way to others that are seen less, where there are any.
SHOWN_SHARES: Final = {"subtle": 0.03, "standard": 0.08, "strong": 0.3}


def check_strength(strength: object) -> str:
    """Return a strength that is one; raises `InputError` that lists the valid ones for anything else."""
    if not isinstance(strength, str) or strength not in BUDGETS:
        raise InputError(f"unknown strength {strength!r}, expected one of {', '.join(BUDGETS)}")
    return strength
