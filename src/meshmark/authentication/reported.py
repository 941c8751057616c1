"""What the marks of authentication report, as evidence of a mark, beside what the ownership layer says."""

from __future__ import annotations

from meshmark.authentication.checks.marked_ids import marked_ids
from meshmark.authentication.one_answer import one_answer
from meshmark.coding.chance import believable
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.extraction_result import Evidence, Extraction

__all__ = ["evidence_of_marks", "marks_evidence", "with_marks"]


def evidence_of_marks(mesh: Mesh, key: Key) -> tuple[Evidence, ...]:
    """Return what the marks of authentication of a mesh report, id by id, that with the largest part first.

    Empty where none of this key are surely there. The bound of each is that of `marked_ids`; its share is the area
    of the points that its marks vouch for, over that of the surface. Raises `InputError` where the mesh has no
    surface.
    """
    surface = surface_of(mesh)
    shares = surface.point_shares
    if not shares.any():
        raise InputError("the model has no surface: all its faces have zero area")
    return tuple(
        Evidence(
            layer="authentication",
            id=each.id,
            log10_false_positive=believable(each.log10_chance),
            share=min(float(shares[each.points].sum()), 1.0),
        )
        for each in marked_ids(surface, key)
    )


def marks_evidence(mesh: Mesh, key: Key) -> Evidence | None:
    """Return the first of `evidence_of_marks`, None where there is none."""
    return next(iter(evidence_of_marks(mesh, key)), None)


def with_marks(found: Extraction, mesh: Mesh, key: Key) -> Extraction:
    """Return the one answer of what was extracted from a mesh and of its marks of authentication (`one_answer`)."""
    return one_answer(found, evidence_of_marks(mesh, key), key=key)
