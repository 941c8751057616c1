"""The certificate of a marked model: a small file with which a suspect can be registered even with half of it gone.

It holds landmarks (centres of smooth windows of the surface, with normals and descriptors), the canonical frame and
the lattice's parameters: neither the surface nor anything of the key. The file is one JSON object:

    format "meshmark certificate", version 3; other versions are refused
    vertices, faces      counts of the marked model
    spacing, step        of the lattice, in canonical units and in spacings; strength subtle, standard or strong
    frame                of the marked model: centre, scale, axes (columns), moments, area, skewness
    landmarks            count, explains (see `geometry.landmarks.Landmarks`), and arrays in base64, little-endian
                         rows: places, normals, masses, curvatures (32-bit floats), descriptors (16-bit floats)
    layers               what was embedded: both, ownership or authentication
    written              of a model with the id alone: keyed digest of its positions, lock and cells of its lattice
                         (see `authentication.as_written`)
    binding              keyed digests of all other fields, of the key, and of the id (see `binding`)
    undo                 sealed data that takes the mark off again (see `undo`)

Fields that a reader does not know are kept as they are, and bound like all others, so later versions of meshmark
can add some.
"""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.geometry.registration.descriptors import DESCRIPTOR_LENGTH
from meshmark.geometry.registration.landmarks import Landmarks
from meshmark.geometry.registration.prepared_surface import PreparedSurface
from meshmark.geometry.shown import Shown
from meshmark.io.atomic_write import write_whole
from meshmark.io.staging import Staging
from meshmark.mesh import FloatArray, Mesh
from meshmark.scene.surfaces import marked_surface, only_repeated
from meshmark.strengths import BUDGETS

__all__ = ["LANDMARKS", "Certificate", "certify"]

LANDMARKS = 400
FORMAT, VERSION = "meshmark certificate", 3
# A certificate has below 100 kB, and about 5 bytes of undo data per vertex; what is far larger is not read.
LONGEST = 200_000_000
MOST_LANDMARKS = 20_000
# Larger numbers do not go into 16 bits; only thousands of sheets on top of each other could give them.
LARGEST = 6e4
_WIDTHS = {"places": 3, "normals": 3, "masses": 1, "curvatures": 1, "descriptors": DESCRIPTOR_LENGTH}
_TYPES = {"descriptors": "<f2"}
_OWN = {"format", "version", "vertices", "faces", "spacing", "step", "strength", "frame", "landmarks"}


@dataclass(frozen=True, eq=False, kw_only=True)
class Certificate:
    """What is kept of a marked model.

    landmarks: in the canonical coordinates of `frame`, which is the marked model's; spacing, step, strength: of its
    lattice; vertices, faces: of its file; more: further fields of the file, plain JSON values.
    """

    landmarks: Landmarks
    frame: Frame
    spacing: float
    step: float
    strength: str
    vertices: int
    faces: int
    more: Mapping[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the fields of the file, plain JSON values."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "vertices": self.vertices,
            "faces": self.faces,
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
            "landmarks": _packed(self.landmarks),
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
        text = json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"
        write_whole(os.fspath(path), text.encode("ascii"), staging)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Certificate:
        """Read a certificate; raises `InputError` that says what is wrong with the file."""
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
            return _parse(content)
        except _OldVersionError as error:
            raise InputError(f"{name} {error}", file=name) from None
        except InputError as error:
            raise InputError(f"{name} is not a meshmark certificate: {error}", file=name) from None

    def summary(self) -> dict[str, Any]:
        """Return what is public of the certificate, for people; nothing of it needs the key.

        model_digest: 16 hexadecimal digits of the marked model's counts and frame, equal for certificates of one
        marked model. takes_mark_off: it holds what `unmark` needs.
        """
        frame = self.frame
        numbers = [
            *frame.centre,
            frame.scale,
            *frame.axes.ravel(),
            *frame.moments,
            frame.area,
            *frame.skewness,
        ]
        content = np.array([self.vertices, self.faces, *numbers], "<f8").tobytes()
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


class _OldVersionError(InputError):
    """A certificate of an earlier meshmark."""


def certify(
    mesh: Mesh, spacing: float, step: float, strength: str, *, repeated_only: bool = False
) -> Certificate:
    """Return the certificate of a marked mesh; raises `InputError` where it has no surface.

    spacing: of the lattice in canonical units; step: of the quantisation, in spacings. repeated_only: the mark lies
    in that part of the scene alone which is shown more than once.
    """
    welded = marked_surface(mesh)
    if repeated_only and isinstance(welded, Shown):
        welded = next(only_repeated(welded), welded)
    frame = canonical_frame(welded.points, welded.faces)
    landmarks = PreparedSurface(welded.points, welded.faces, frame).landmarks(LANDMARKS)
    return Certificate(
        landmarks=_rounded(landmarks),
        frame=frame,
        spacing=float(spacing),
        step=float(step),
        strength=strength,
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
    )


def _rounded(landmarks: Landmarks) -> Landmarks:
    """Return the landmarks as a file holds them, so that a certificate is the same after a round trip."""
    return _unpacked(_packed(landmarks))


def _packed(landmarks: Landmarks) -> dict[str, Any]:
    values: dict[str, Any] = {"count": len(landmarks), "explains": landmarks.explains}
    for name in _WIDTHS:
        array = np.clip(getattr(landmarks, name), -LARGEST, LARGEST).astype(_TYPES.get(name, "<f4"))
        values[name] = base64.b64encode(array.tobytes()).decode("ascii")
    return values


def _unpacked(values: dict[str, Any]) -> Landmarks:
    count = _number(values, "count", 0, MOST_LANDMARKS, whole=True)
    arrays = {name: _array(values, name, int(count), width) for name, width in _WIDTHS.items()}
    lengths = np.sqrt((arrays["normals"] ** 2).sum(axis=1))
    if (np.abs(lengths - 1.0) > 1e-3).any():
        raise InputError("a normal does not have the length 1")
    if not (arrays["masses"] > 0.0).all():
        raise InputError("a landmark has no mass")
    return Landmarks(
        places=arrays["places"],
        normals=arrays["normals"],
        masses=arrays["masses"][:, 0],
        curvatures=arrays["curvatures"][:, 0],
        descriptors=arrays["descriptors"],
        explains=_number(values, "explains", 1e-6, 1.0),
    )


def _array(values: dict[str, Any], name: str, count: int, width: int) -> FloatArray:
    text = values.get(name)
    kind = np.dtype(_TYPES.get(name, "<f4"))
    try:
        content = base64.b64decode(text if isinstance(text, str) else "-", validate=True)
    except ValueError:
        raise InputError(f"'{name}' is not an array in base64") from None
    if len(content) != count * width * kind.itemsize:
        raise InputError(f"'{name}' holds {len(content)} bytes, expected {count * width * kind.itemsize}")
    array = np.frombuffer(content, kind).astype(np.float64).reshape(count, width)
    if not np.isfinite(array).all():
        raise InputError(f"'{name}' holds a number that is not finite")
    return array


def _parse(content: bytes) -> Certificate:
    try:
        values = json.loads(content.decode("utf-8"), parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise InputError("it is not JSON") from None
    if not isinstance(values, dict) or values.get("format") != FORMAT:
        raise InputError(f"expected a JSON object with the format '{FORMAT}'")
    version = values.get("version")
    if type(version) is int and 0 < version < VERSION:
        raise _OldVersionError(
            f"is a certificate of version {version}, expected {VERSION}: older ones are sealed otherwise and no "
            "longer read; go without it, or mark the original again"
        )
    if type(version) is not int or version != VERSION:
        raise InputError(f"its version is {version!r}, expected {VERSION}")
    strength = values.get("strength")
    if not isinstance(strength, str) or strength not in BUDGETS:
        raise InputError(f"'strength' is {strength!r}, expected one of {', '.join(BUDGETS)}")
    return Certificate(
        landmarks=_unpacked(_table(values, "landmarks")),
        frame=_frame(_table(values, "frame")),
        spacing=_number(values, "spacing", 1e-6, 1e3),
        step=_number(values, "step", 1e-6, 1e3),
        strength=strength,
        vertices=int(_number(values, "vertices", 0, 1e15, whole=True)),
        faces=int(_number(values, "faces", 0, 1e15, whole=True)),
        more={name: value for name, value in values.items() if name not in _OWN},
    )


def _refuse(word: str) -> NoReturn:
    raise ValueError(word)


def _table(values: dict[str, Any], name: str) -> dict[str, Any]:
    table = values.get(name)
    if not isinstance(table, dict):
        raise InputError(f"'{name}' is missing or no object")
    return table


def _number(values: dict[str, Any], name: str, low: float, high: float, whole: bool = False) -> float:
    value = values.get(name)
    if type(value) is not int and (whole or type(value) is not float):
        raise InputError(f"'{name}' is missing or no {'whole ' if whole else ''}number")
    if not low <= value <= high:  # nor is NaN; whole numbers may be too large for a float
        raise InputError(f"'{name}' is out of range, expected {low:g} to {high:g}")
    return float(value)


def _frame(values: dict[str, Any]) -> Frame:
    centre, moments, skewness = (_numbers(values, name, (3,)) for name in ("centre", "moments", "skewness"))
    axes = _numbers(values, "axes", (3, 3))
    if np.abs(axes.T @ axes - np.eye(3)).max() > 1e-6 or np.linalg.det(axes) < 0.0:
        raise InputError("'axes' is not a rotation")
    scale, area = _number(values, "scale", 1e-100, 1e100), _number(values, "area", 1e-12, 1e12)
    return Frame(centre=centre, scale=scale, axes=axes, moments=moments, area=area, skewness=skewness)


def _numbers(values: dict[str, Any], name: str, shape: tuple[int, ...]) -> FloatArray:
    try:
        array = np.array(values.get(name), dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.zeros(0)
    if array.shape != shape or not np.isfinite(array).all():
        raise InputError(f"'{name}' is missing, or not {' by '.join(map(str, shape))} finite numbers")
    return array
