"""The certificate of a marked model: a small file with which a suspect can be registered even with half of it gone.

It holds landmarks (centres of smooth windows of the surface, with normals and descriptors), the canonical frame and
the lattice's parameters: neither the surface nor anything of the key. The file is one JSON object:

    format "meshmark certificate", version 4; other versions are refused
    vertices, faces      counts of the marked model
    lattice              label of the lattice among those of the key, 32 hexadecimal digits
    spacing, step        of the lattice, in canonical units and in spacings; strength subtle, standard or strong
    frame                that the mark was made in: centre, scale, axes (columns), moments, area, skewness
    landmarks            count, explains (see `geometry.landmarks.Landmarks`), and arrays in base64, little-endian
                         rows: places, normals, masses, curvatures (32-bit floats), descriptors (16-bit floats)
    layers               what was embedded: both, ownership or authentication
    carriers             of the id: cells or points
    corners              of some triangles, canonical, in base64, as the landmarks are
    written              of a model with the id alone: keyed digest of its positions, lock and cells of its lattice
                         (see `authentication.as_written`)
    binding              keyed digests of all other fields, of the key, and of the id; and the id, sealed, which
                         earlier certificates do not have (see `binding`)
    undo                 sealed data that takes the mark off again (see `undo`)

Fields that a reader does not know are kept as they are, and bound like all others, so later versions of meshmark
can add some.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.frame import Frame
from meshmark.mesh import FloatArray

if TYPE_CHECKING:
    from meshmark.geometry.registration.landmarks import Landmarks
    from meshmark.io.staging import Staging

__all__ = ["Certificate"]

# A certificate has below 100 kB, and about 5 bytes of undo data per vertex; what is far larger is not read.
LONGEST = 200_000_000


@dataclass(frozen=True, eq=False, kw_only=True)
class Certificate:
    """What is kept of a marked model.

    landmarks: in the canonical coordinates of `frame`, in which the mark was made; lattice: its label, 32
    hexadecimal digits; spacing, step, strength: of it; vertices, faces: of its file; more: further fields of the
    file, plain JSON values.
    """

    landmarks: Landmarks
    frame: Frame
    lattice: str
    spacing: float
    step: float
    strength: str
    vertices: int
    faces: int
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def at_points(self) -> bool:
        """Return whether the id lies in points of the model, not in cells of its surface."""
        return self.more.get("carriers") == "points"

    @property
    def corners(self) -> FloatArray:
        """Return the corners (k, 3, 3) of triangles of the model; raises `InputError` where they are spoilt."""
        from meshmark.certificate.certificate_fields import unpacked_corners

        return unpacked_corners(self.more.get("corners", ""))

    def to_dict(self) -> dict[str, Any]:
        """Return the fields of the file, plain JSON values."""
        from meshmark.certificate.certificate_fields import FORMAT, VERSION, packed

        return {
            "format": FORMAT,
            "version": VERSION,
            "vertices": self.vertices,
            "faces": self.faces,
            "lattice": self.lattice,
            "spacing": self.spacing,
            "step": self.step,
            "strength": self.strength,
            "frame": {
                "centre": self.frame.centre.tolist(),
                "scale": self.frame.scale,
                "axes": self.frame.axes.tolist(),
                "moments": self.frame.moments.tolist(),
                "area": self.frame.area,
                "skewness": self.frame.skewness.tolist(),
            },
            "landmarks": packed(self.landmarks),
            **self.more,
        }

    def canonical(self, without: str) -> bytes:
        """Return the fields but one in a fixed order and spelling, the same before and after a round trip.

        Raises `InputError` where further fields are nested too deeply.
        """
        values = {name: value for name, value in self.to_dict().items() if name != without}
        try:
            return json.dumps(values, sort_keys=True, separators=(",", ":")).encode("ascii")
        except RecursionError:
            raise InputError("the certificate's fields are nested too deeply") from None

    def save(self, path: str | os.PathLike[str], staging: Staging | None = None) -> None:
        """Write the certificate; raises `OutputError` where the file cannot be written.

        staging: takes the file, to move it into place together with others.
        """
        from meshmark.io.atomic_write import write_whole

        text = json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"
        write_whole(os.fspath(path), text.encode("ascii"), staging)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Certificate:
        """Read a certificate; raises `InputError` that says what is wrong with the file."""
        from meshmark.certificate.certificate_fields import OldVersionError, read_fields

        name = os.fspath(path)
        try:
            with Path(path).open("rb") as file:
                content = file.read(LONGEST + 1)
        except OSError as error:
            raise InputError(
                f"cannot read the certificate {name}: {error.strerror or 'error'}", file=name
            ) from None
        if len(content) > LONGEST:
            raise InputError(
                f"{name} is not a meshmark certificate: it is longer than {LONGEST} bytes", file=name
            )
        try:
            return cls(**read_fields(content))
        except OldVersionError as error:
            raise InputError(f"{name} {error}", file=name) from None
        except InputError as error:
            raise InputError(f"{name} is not a meshmark certificate: {error}", file=name) from None

    def summary(self) -> dict[str, Any]:
        """Return what is public of the certificate, for people; nothing of it needs the key.

        model_digest: 16 hexadecimal digits of the marked model's counts, frame, landmarks and corners, equal for
        certificates of one marked model. takes_mark_off: it holds what `unmark` needs.
        """
        from meshmark.certificate.certificate_fields import FORMAT, VERSION, packed

        frame = self.frame
        numbers = [
            *frame.centre,
            frame.scale,
            *frame.axes.ravel(),
            *frame.moments,
            frame.area,
            *frame.skewness,
        ]
        shape = json.dumps([packed(self.landmarks), self.more.get("corners")], sort_keys=True)
        content = np.array([self.vertices, self.faces, *numbers], "<f8").tobytes() + shape.encode()
        return {
            "kind": FORMAT,
            "certificate_version": VERSION,
            "layers": self.more.get("layers"),
            "vertices": self.vertices,
            "faces": self.faces,
            "strength": self.strength,
            "landmarks": len(self.landmarks),
            "model_digest": blake2b(content, digest_size=8, person=b"meshmark model").hexdigest(),
            "bound_to_key": "binding" in self.more,
            "takes_mark_off": "undo" in self.more,
        }
