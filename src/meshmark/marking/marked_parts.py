"""What an embedding says of parts that carry the id by themselves."""

from __future__ import annotations

from meshmark.ownership.ownership_mark import OwnershipMark

__all__ = ["parts_in_words"]


def parts_in_words(mark: OwnershipMark) -> tuple[str, ...]:
    """Return a remark about the parts that carry the id by themselves, none where there are none."""
    if not mark.parts:
        return ()
    what = "id" if mark.bits else "mark"
    if len(mark.parts) == 1:
        return (f"one part carries the {what} by itself as well, and tells it when it is taken out",)
    return (
        f"{len(mark.parts)} parts carry the {what} by themselves as well, and tell it when they are taken out",
    )
