"""The fields of a certificate's file: JSON with arrays in base64, each checked before it is believed."""

from __future__ import annotations

import base64
import json
import re
from typing import Any, Final, NoReturn

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.frame import Frame
from meshmark.geometry.registration.descriptors import DESCRIPTOR_LENGTH
from meshmark.geometry.registration.landmarks import Landmarks
from meshmark.mesh import FloatArray
from meshmark.strengths import check_strength

__all__ = [
    "FORMAT",
    "VERSION",
    "OldVersionError",
    "packed",
    "packed_corners",
    "read_fields",
    "unpacked",
    "unpacked_corners",
]

FORMAT: Final = "meshmark certificate"
"""What the field `format` says."""
VERSION: Final = 4
"""Of the files that are written and read."""
_MOST_LANDMARKS = 20_000
# Larger numbers do not go into 16 bits; only thousands of sheets on top of each other could give them.
_LARGEST = 6e4
_WIDTHS = {"places": 3, "normals": 3, "masses": 1, "curvatures": 1, "descriptors": DESCRIPTOR_LENGTH}
_TYPES = {"descriptors": "<f2"}
_LABEL = re.compile(r"[0-9a-f]{32}")
_OWN = {
    "format",
    "version",
    "vertices",
    "faces",
    "lattice",
    "spacing",
    "step",
    "strength",
    "frame",
    "landmarks",
}


class OldVersionError(InputError):
    """A certificate of an earlier meshmark."""


def read_fields(content: bytes) -> dict[str, Any]:
    """Return the fields of a certificate from the bytes of its file.

    Parameters
    ----------
    content : bytes

    Returns
    -------
    dict
        Arguments of `Certificate`.

    Raises
    ------
    OldVersionError
        The file is a certificate of an earlier meshmark.
    InputError
        It is no certificate; the message says why, without the name of the file.
    """
    try:
        values = json.loads(content.decode("utf-8"), parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise InputError("it is not JSON") from None
    if not isinstance(values, dict) or values.get("format") != FORMAT:
        raise InputError(f"expected a JSON object with the format '{FORMAT}'")
    version = values.get("version")
    if type(version) is int and 0 < version < VERSION:
        raise OldVersionError(
            f"is a certificate of version {version}, expected {VERSION}: marks of earlier versions are no "
            "longer read; mark the original again"
        )
    if type(version) is not int or version != VERSION:
        raise InputError(f"its version is {version!r}, expected {VERSION}")
    strength = check_strength(values.get("strength"))
    return {
        "landmarks": unpacked(_table(values, "landmarks")),
        "frame": _frame(_table(values, "frame")),
        "lattice": _label(values),
        "spacing": _number(values, "spacing", 1e-6, 1e3),
        "step": _number(values, "step", 1e-6, 1e3),
        "strength": strength,
        "vertices": int(_number(values, "vertices", 0, 1e15, whole=True)),
        "faces": int(_number(values, "faces", 0, 1e15, whole=True)),
        "more": {name: value for name, value in values.items() if name not in _OWN},
    }


def _refuse(word: str) -> NoReturn:
    raise ValueError(word)


def _label(values: dict[str, Any]) -> str:
    label = values.get("lattice")
    if not isinstance(label, str) or not _LABEL.fullmatch(label):
        raise InputError("'lattice' is missing or not 32 hexadecimal digits")
    return label


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


def packed(landmarks: Landmarks) -> dict[str, Any]:
    """Return landmarks as JSON values, arrays in base64."""
    values: dict[str, Any] = {"count": len(landmarks), "explains": landmarks.explains}
    for name in _WIDTHS:
        array = np.clip(getattr(landmarks, name), -_LARGEST, _LARGEST).astype(_TYPES.get(name, "<f4"))
        values[name] = base64.b64encode(array.tobytes()).decode("ascii")
    return values


def packed_corners(corners: FloatArray) -> str:
    """Return the corners (k, 3, 3) of triangles in base64."""
    return base64.b64encode(corners.astype("<f4").tobytes()).decode("ascii")


def unpacked_corners(text: object) -> FloatArray:
    """Undo `packed_corners`; raises `InputError` for what it does not make."""
    try:
        data = base64.b64decode(text if isinstance(text, str) else "?", validate=True)
        corners = np.frombuffer(data, "<f4").astype(np.float64).reshape(-1, 3, 3)
    except ValueError:
        raise InputError("'corners' is not base64 of triangles") from None
    if not np.isfinite(corners).all():
        raise InputError("'corners' holds numbers that are not finite")
    return corners


def unpacked(values: dict[str, Any]) -> Landmarks:
    """Undo `packed`; raises `InputError` for values that it does not make."""
    count = _number(values, "count", 0, _MOST_LANDMARKS, whole=True)
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
