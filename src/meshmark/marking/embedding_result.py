"""What an embedding returns; `to_dict` is the JSON of the command line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isinf
from typing import TYPE_CHECKING, Any

from meshmark.coding.message import bits_of, format_id
from meshmark.mesh import Mesh
from meshmark.notebook import notebook_table
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.ownership.parameters import SPACINGS, STEPS
from meshmark.ownership.vertex_displacement import VertexDisplacement

if TYPE_CHECKING:
    from meshmark.certificate.certificate import Certificate

__all__ = ["AuthenticationMark", "Embedding"]


@dataclass(frozen=True, kw_only=True)
class AuthenticationMark:
    """Marks of the authentication layer that were read back.

    marks: number of vertices that carry one. payload_bytes: of content in the payload. tolerance: what the marks
    bear, "strict", "default", "tolerant" or "web".
    """

    marks: int
    payload_bytes: int
    tolerance: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Embedding:
    """A marked mesh, each layer of which was read back from the positions that its file can hold.

    mesh: write it with `write_mesh(embedding.mesh, path)`. id: of 64 or 32 bits, None where the mark carries
    none. strength: "subtle", "standard" or
    "strong". ownership, authentication: the layers, None for one that was not embedded. displacement: of the
    vertices, by all layers together. remarks: sentences about how the file was read, what was left out, and what a
    conversion dropped. seconds: wall-clock time. seal: adds to the certificate what takes the mark off again.
    """

    mesh: Mesh
    id: int | None
    strength: str
    ownership: OwnershipMark | None
    authentication: AuthenticationMark | None
    displacement: VertexDisplacement
    remarks: tuple[str, ...] = ()
    seconds: float = 0.0
    seal: Callable[[Certificate], Certificate] | None = field(default=None, repr=False)

    @property
    def layers(self) -> str:
        """Return which layers were embedded: "both", "ownership" or "authentication"."""
        if self.ownership is None:
            return "authentication"
        return "ownership" if self.authentication is None else "both"

    @property
    def bits(self) -> int:
        """Return of how many bits the id is; 0 where there is none."""
        return 0 if self.id is None else bits_of(self.id)

    @property
    def vertices(self) -> int:
        """Return the number of vertices of the file."""
        return len(self.mesh.vertices)

    @property
    def faces(self) -> int:
        """Return the number of triangles of the file."""
        return len(self.mesh.faces)

    @property
    def carriers(self) -> int:
        """Return the number of cells that carry the id, 0 without the ownership layer."""
        return 0 if self.ownership is None else self.ownership.carriers

    @property
    def mark_vertices(self) -> int:
        """Return the number of vertices with a mark of authentication."""
        return 0 if self.authentication is None else self.authentication.marks

    @property
    def payload_bytes(self) -> int:
        """Return the bytes of content in the payload."""
        return 0 if self.authentication is None else self.authentication.payload_bytes

    @property
    def rms_over_diagonal(self) -> float:
        """Return the RMS displacement of vertices over the bounding-box diagonal."""
        return self.displacement.rms_over_diagonal

    @property
    def max_over_diagonal(self) -> float:
        """Return the largest displacement of a vertex over the bounding-box diagonal."""
        return self.displacement.max_over_diagonal

    @property
    def psnr_db(self) -> float:
        """Return 20 log10(diagonal / RMS), infinite where nothing moved."""
        return self.displacement.psnr_db

    @cached_property
    def certificate(self) -> Certificate:
        """What to keep of the marked model, so that its mark is found in a damaged copy, or taken off again."""
        from meshmark.certificate.certify import certify

        # The file has no way to say that there is no lattice: without the layer it names the first of the grid.
        mark = self.ownership
        if mark is None:
            made = certify(self.mesh, float(SPACINGS[0]), float(STEPS[0]), self.strength)
        else:
            made = certify(
                self.mesh,
                mark.spacing,
                mark.step,
                self.strength,
                lattice=str(mark.label),
                frame=mark.frame,
                repeated_only=mark.repeated_only,
                at_points=mark.at_points,
            )
        made = replace(made, more={**made.more, "layers": self.layers})
        return made if self.seal is None else self.seal(made)

    def _repr_html_(self) -> str:
        moved = f"{100 * self.rms_over_diagonal:.2g} % RMS, {100 * self.max_over_diagonal:.2g} % at most"
        marks = "" if self.authentication is None else f"{self.mark_vertices:,}"
        return notebook_table(
            "Marked",
            [
                ("Id", "none" if self.id is None else format_id(self.id)),
                ("Layers", self.layers),
                ("Strength", self.strength),
                ("Size", f"{self.vertices:,} vertices, {self.faces:,} faces"),
                ("Displacement of the diagonal", moved),
                ("Marks of authentication", marks),
                ("Remarks", " ".join(self.remarks)),
            ],
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields: the id in hexadecimal, null for what is not there."""
        psnr = self.psnr_db
        return {
            "id": None if self.id is None else format_id(self.id),
            "bits": self.bits,
            "layers": self.layers,
            "vertices": self.vertices,
            "faces": self.faces,
            "carriers": self.carriers,
            "mark_vertices": self.mark_vertices,
            "payload_bytes": self.payload_bytes,
            "tolerance": None if self.authentication is None else self.authentication.tolerance,
            "rms_over_diagonal": self.rms_over_diagonal,
            "max_over_diagonal": self.max_over_diagonal,
            "psnr_db": None if isinf(psnr) else psnr,
            "seconds": self.seconds,
            "strength": self.strength,
            "spacing": None if self.ownership is None else self.ownership.spacing,
            "step": None if self.ownership is None else self.ownership.step,
            "remarks": self.remarks,
        }
