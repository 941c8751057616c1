"""Networks as small JSON files: the weights beside the command, seed and figures that made them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

import numpy as np

from meshmark.errors import InputError
from meshmark.network.perceptron import Perceptron

__all__ = ["dump_network", "parse_network", "shipped_network"]

KIND = "meshmark network 1"


def dump_network(network: Perceptron, features: Sequence[str], notes: Mapping[str, Any]) -> str:
    """Return a network as JSON text; its numbers are kept to the last bit.

    features: what its inputs are, in order; notes: how it was made, and how good it is.
    """
    if len(features) != network.sizes[0]:
        raise InputError(f"{len(features)} features are named, expected {network.sizes[0]}")
    fields = {
        "kind": KIND,
        **notes,
        "features": list(features),
        "sizes": list(network.sizes),
        "centre": network.centre.tolist(),
        "scale": network.scale.tolist(),
        "weights": network.weights.tolist(),
    }
    lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in fields.items())
    return "{\n" + lines + "\n}\n"


def parse_network(text: str, features: Sequence[str]) -> Perceptron:
    """Return the network of a JSON text; raises `InputError` unless it takes exactly these features."""
    try:
        fields = json.loads(text)
        if fields["kind"] != KIND:
            raise InputError(f"the network file is of kind '{fields['kind']}', expected '{KIND}'")
        named = tuple(fields["features"])
        parts = {name: np.array(fields[name], dtype=np.float64) for name in ("centre", "scale", "weights")}
        sizes = tuple(int(size) for size in fields["sizes"])
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"the text is not a network file: {error!r}") from error
    if named != tuple(features):
        raise InputError(f"the network takes {', '.join(named)}, expected {', '.join(features)}")
    return Perceptron(sizes=sizes, **parts)


def shipped_network(name: str, features: Sequence[str]) -> Perceptron:
    """Return the network shipped under this name, such as "demodulator"."""
    file = resources.files("meshmark.network").joinpath("weights", f"{name}.json")
    return parse_network(file.read_text("utf-8"), features)
