"""A mark that holds, but says another symbol than the payload has there, vouches for nothing."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from meshmark.authentication.checks.altered_points import altered_points
from meshmark.authentication.checks.checks import check
from meshmark.authentication.marks.plan import mark, plan
from meshmark.authentication.marks.precision import precision_of
from meshmark.authentication.payload.payload import encoder, pack
from meshmark.authentication.payload.signed_totals import whole_of
from meshmark.geometry.weld import weld
from meshmark.marking import authenticate
from meshmark.mesh import Mesh
from tests.keys import KEY
from tests.shapes import pebble

ID = 0x0123456789ABCDEF


@pytest.mark.parametrize("lies", [0, 1, 5])
def test_marks_that_contradict_the_payload_are_altered_and_no_others(lies):
    mesh = Mesh(*pebble(48))
    surface, precision = weld(mesh), precision_of(mesh)
    planned = plan(surface, KEY, precision)
    index, times = np.unique(planned.payload_index, return_counts=True)
    source = encoder(
        pack("bytes", b"a message", whole_of(surface, precision)), planned.symbol_bits, len(index)
    )
    liars = index[times == 1][:: len(index) // 7][:lies]

    def symbols(asked: NDArray[np.uint32]) -> NDArray[np.uint16]:
        return source(asked) ^ np.isin(asked, liars)

    marked = mesh.with_vertices(mark(planned, KEY, ID, symbols).points[surface.point_of_vertex])
    checks = check(weld(marked), KEY)
    assert not altered_points(weld(marked), checks).any()  # each of the marks holds
    found = authenticate(marked, KEY)
    assert found.verdict == ("altered" if lies else "authentic")
    assert found.content is not None
    assert found.content.content == b"a message"
    liar = checks.carried.vertex[np.isin(checks.carried.index, liars)]
    assert len(liar) == lies
    assert found.altered[liar].all()
    near = np.isin(marked.faces, liar).any(axis=1)
    assert not np.delete(found.altered, marked.faces[near]).any()
