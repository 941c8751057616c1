"""What the answer of a report means and what it does not, for readers who know nothing of watermarks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

__all__ = ["MEANINGS", "Meaning"]

_NOT_WHEN = "It does not say who changed the file, when, or why."
_KEY = "Anyone with the key can make such marks: it is worth as much as the key is well kept."
_TEXTURES = (
    "Materials and textures are compared in glTF files only; in other formats, the surface alone is covered."
)
_SYMMETRIC = (
    "Whoever checks the mark needs the key. To convince a third party, hand over a registry's proof or let "
    "a trustee keep the key; the mark alone does not show who made the model first."
)


@dataclass(frozen=True, kw_only=True)
class Meaning:
    """Sentences on what an answer means, and on what it must not be taken for."""

    means: tuple[str, ...]
    not_means: tuple[str, ...]


MEANINGS: Final = {
    "authentic": Meaning(
        means=(
            "The surface is the one that was marked with this key. It may have been turned, resized, moved,"
            " converted to another format, or rounded as far as its marks bear.",
        ),
        not_means=(_TEXTURES, _KEY),
    ),
    "surface_intact": Meaning(
        means=(
            "The surface is the one that was marked with this key. Viewers of the file show something else,"
            " as named above.",
        ),
        not_means=(
            "The pictures here show the surface alone, not what a viewer makes of the file.",
            _TEXTURES,
            _KEY,
        ),
    ),
    "altered": Meaning(
        means=(
            "Where the map is coloured, checks failed: the surface there is not the one that was signed "
            "off. Where it is not, the marks hold.",
            "Blue parts were moved as one, or may have been; inside, they are as they were.",
        ),
        not_means=(
            "The colour says how many checks failed around a place, not how far it was moved. A whole "
            "region is not altered because some of its checks failed.",
            _NOT_WHEN,
            _TEXTURES,
        ),
    ),
    "not_marked": Meaning(
        means=("No mark of authentication of this key was found.",),
        not_means=(
            "It does not show that the model was never marked: editing everywhere removes these marks, and "
            "marks of another key are not seen with this one.",
            "Whether the owner's id is left, the extraction (`meshmark extract`) tells.",
        ),
    ),
    "inconclusive": Meaning(
        means=("What is left of the mark is too little to say whether the model was changed.",),
        not_means=(
            "It is neither a yes nor a no. A larger part of the model, its certificate or its original may "
            "tell more.",
        ),
    ),
    "present": Meaning(
        means=(
            "The model, or a part of it, carries a mark that was made with this key, with the id given above.",
        ),
        not_means=(
            "It does not say that the model is unchanged, nor who passed it on.",
            _SYMMETRIC,
            _KEY,
        ),
    ),
    "unread": Meaning(
        means=("Something of a mark may be there, but too little to be sure, or to read its id.",),
        not_means=(
            "It is neither a yes nor a no. A larger part of the model, its certificate or its original may "
            "tell more.",
        ),
    ),
    "absent": Meaning(
        means=("No mark of this key was found, in any of the ways that were tried.",),
        not_means=(
            "It does not show that the model is not a copy: a part of it, or a badly damaged copy, may need"
            " its certificate or its original to be read.",
            "Marks of another key are not seen with this one.",
        ),
    ),
    "marked": Meaning(
        means=(
            "The marked file was read back with the key alone before it was saved. The mark moves the "
            "surface as far as the displacement layer shows, and nothing else in the file.",
        ),
        not_means=(
            "A mark does not prevent copying, and it can be removed at the price of damage to the surface.",
            "This page is not for strangers: where the surface was moved tells where the mark is.",
            _SYMMETRIC,
        ),
    ),
    "recovered": Meaning(
        means=(
            "What is coloured was restored from the miniature that the model carries, or closed over; "
            "everything else is as it was signed off.",
        ),
        not_means=(
            "A miniature has less detail than the model: restored parts show the shape that was there, not "
            "its fine detail.",
            "A restored model is no longer the signed one. It is not authentic in its restored parts.",
        ),
    ),
    "recovered_copy": Meaning(
        means=(
            "What is coloured was restored from the marked copy; everything else is as it was signed off.",
        ),
        not_means=(
            "How well it fits the signed copy is said above; where libraries round otherwise, last digits "
            "differ.",
            _KEY,
        ),
    ),
    "recovered_original": Meaning(
        means=(
            "What is coloured was restored from the unmarked original; everything else is as it was signed off.",
        ),
        not_means=(
            "A restored model is no longer the signed one: its restored parts carry no marks, and are not "
            "authentic.",
        ),
    ),
}
"""By verdict of an authentication; of an extraction: "present", "absent", or "unread"; "marked"; "recovered" and
what from."""
