"""Rich text files for tests: everything literal but the coordinates, which fill the @ slots in file order."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

TETRA = ("0.000000", "0.000000", "0.000000", "1.250000", "0.000000", "-0.000001")
TETRA += ("0.500000", "12.125000", "0.000000", "0.333333", "0.250000", "0.707107")


@dataclass(frozen=True)
class Sample:
    """A file as a template; numbers fill its slots; `axes` says which coordinate each slot of a row is."""

    suffix: str
    template: str
    numbers: tuple[str, ...] = TETRA
    faces: int = 4
    axes: tuple[int, int, int] = (0, 1, 2)

    def fill(self, numbers: tuple[str, ...] | list[str]) -> bytes:
        parts = self.template.split("@")
        assert len(parts) == len(numbers) + 1
        whole = "".join(text + number for text, number in zip(parts, [*numbers, ""], strict=True))
        return whole.encode("utf-8")

    @property
    def data(self) -> bytes:
        return self.fill(self.numbers)

    def read(self, data: bytes) -> list[str]:
        """Return what stands in the slots of a file that is this template in all else; fail if it is not."""
        pattern = r"([^\s#/]+)".join(re.escape(part) for part in self.template.split("@"))
        found = re.fullmatch(pattern, data.decode("utf-8"))
        assert found is not None, "something other than coordinates has changed"
        return list(found.groups())

    def positions(self, words: list[str] | tuple[str, ...]) -> np.ndarray:
        rows = np.array([float(word) for word in words]).reshape(-1, 3)
        return rows[:, np.argsort(self.axes)]


V = "@ @ @\n"
F = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
OBJ_RICH = """# made by hand, v 1 2 3 in a comment\r
mtllib scene.mtl other file.mtl\r
o Left Arm\r
v @ @ @\r
v\t@\t@\t@   # why\r
 v  @  @  @ \r
vt 0.5 0.25\r
vt 1 0\r
vn 0 0 1\r
g one two\r
usemtl Shiny #1\r
s 1\r
v @ @ @\r
f 1/1/1 3/2/1 2/1/1\r
f 1//1 2//1 4//1\r
s off\r
f -4/1 -1/2 -2/1\r
f \\\r
 2 3 \\\r
 4\r
l 1 2\r
p 3\r
curv2 1 2\r
unknown v 1 2 3\r
\r
"""

PLY = (
    "ply\nformat ascii 1.0\ncomment v 1 2 3\nobj_info made by hand\nelement vertex 4\nproperty float x\n"
    "property float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
)
FACET = "facet normal {}\nouter loop\n" + "vertex @ @ @\n" * 3 + "endloop\nendfacet\n"
STL = "solid of two facets\n" + FACET.format("-1.#IND 1.#IND 1.#QNAN") + FACET.format("0 0 1") + "endsolid\n"

SAMPLES = {
    "off": Sample(".off", "OFF\n4 4 6\n" + V * 4 + F),
    "off on one line": Sample(".off", "OFF 4 4 0 " + "@ @ @ " * 4 + F.replace("\n", "  ")),
    "off no edge count": Sample(".off", "OFF\n4 4\n" + V * 4 + F),
    "off glued count": Sample(".off", "\t OFF4 4 6 # hm\n" + V * 4 + F),
    "off lower case": Sample(".off", "off\n4 4 6\n" + V * 4 + F),
    "off crlf comments": Sample(
        ".off",
        "# 1 2 3\r\nOFF # so\r\n\r\n4 4 6\r\n#\r\n" + "@\t@  @ # 9 9 9\r\n\r\n" * 4 + F.replace("\n", "\r\n"),
    ),
    "off cr only": Sample(".off", ("OFF\n4 4 6\n" + V * 4 + F).replace("\n", "\r")),
    "off bom": Sample(".off", "\ufeffOFF\n4 4 6\n" + V * 4 + F),
    "off without last newline": Sample(".off", ("OFF\n4 4 6\n" + V * 4 + F).rstrip("\n")),
    "off polygons and face colours": Sample(
        ".off", "OFF\n4 3 0\n" + V * 4 + "4 0 1 2 3 255 0 0\n3 0 1 2 0.5 0.5 0.5 1\n3 1 2 3\n", faces=4
    ),
    "coff": Sample(".off", "COFF\n4 4 0\n" + "@ @ @ 255 128 0 255\n" * 4 + F),
    "coff three": Sample(".off", "COFF\n4 4 0\n" + "@ @ @ 0.5 0.25 1\n" * 4 + F),
    "noff": Sample(".off", "NOFF\n4 4 0\n" + "@ @ @ 0 0 1\n" * 4 + F),
    "stcnoff": Sample(".off", "STCNOFF\n4 4 0\n" + "@ @ @ 0 0 1 10 20 30 40 0.25 0.75\n" * 4 + F),
    "obj": Sample(".obj", OBJ_RICH),
    "obj w": Sample(".obj", "v @ @ @ 1.0\n" * 4 + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"),
    "obj colours": Sample(".obj", "v @ @ @ 0.1 0.2 0.3\n" * 4 + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4"),
    "obj polygon": Sample(".obj", "v @ @ @\n" * 4 + "f 1 2 3 4\nf 4// 3// 2//\n", faces=3),
    "ply": Sample(
        ".ply",
        PLY + V * 4 + F,
    ),
    "ply mixed up": Sample(
        ".ply",
        "ply\r\nformat ascii 1.0\r\nelement camera 1\r\nproperty list uint8 float32 view\r\nproperty int id\r\n"
        "element vertex 4\r\nproperty uchar red\r\nproperty double z\r\nproperty list uchar short tags\r\n"
        "property float x\r\nproperty float nx\r\nproperty double y\r\n"
        "element face 3\r\nproperty uchar flags\r\nproperty list uchar uint vertex_index\r\n"
        "property list uchar float texcoord\r\nelement edge 0\r\nproperty int vertex1\r\nend_header\r\n"
        "3 0.5 0.25 1e-3 7\r\n"
        + "".join(f"255 @ {k} {'9 ' * k}@ -1 @\r\n" for k in (0, 2, 1, 0))
        + "1 4 0 1 2 3 2 0.5 0.5\r\n0 3 0 1 2 0\r\n0 3 1 2 3 1 4\r\n",
        axes=(2, 0, 1),
        faces=4,
    ),
    "ply strips": Sample(
        ".ply",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
        + V * 4
        + "9 0 1 2 3 -1 3 2 1 -1\n",
        faces=3,
    ),
    "obj with what is not finite and a face without corners": Sample(
        ".obj",
        "v @ @ @\nv nan -nan(ind) 1.#QNAN\nv @ @ @\nv inf 0 0 # gone\nvt nan 1.#INF\nvn 1.#IND 0 -1.#IND00\n"
        "v @ @ @\nv @ @ @\nf 1/1/1 5/1/1 3/1/1\nf\nf 1 3 6\nf -1 -2 -6\nf  # none\nf 3 5 6\nf 2 4\n",
    ),
    "off with a vertex that is not finite": Sample(
        ".off", "OFF\n5 4 0\n" + V * 2 + "nan inf 0\n" + V * 2 + "3 0 3 1\n3 0 1 4\n3 0 4 3\n3 1 3 4\n"
    ),
    "off with more than it declares": Sample(
        ".off", "OFF\n4 4 0\n" + V * 4 + F + "2 0 1\n and notes, 3 of them\n"
    ),
    "off on one line with more than it declares": Sample(
        ".off", "OFF 4 4 0 " + "@ @ @ " * 4 + F.replace("\n", "  ") + "3 0 1 the end"
    ),
    "off one face short": Sample(".off", "OFF\n4 5 0\n" + V * 4 + F),
    "ply with more than it declares": Sample(".ply", PLY + V * 4 + F + "\n\n1 2 see you\n"),
    "ply one face short": Sample(".ply", PLY.replace("face 4", "face 5") + V * 4 + F),
    "ply with a vertex that is not finite": Sample(
        ".ply",
        PLY.replace("vertex 4", "vertex 5") + "nan 0 -inf\n" + V * 4 + "3 1 3 2\n3 1 2 4\n3 1 4 3\n3 2 3 4\n",
    ),
    "ply int64": Sample(".ply", PLY.replace("uchar int", "uint64 int64") + V * 4 + F),
    "stl with comments first": Sample(
        ".stl",
        "# made by hand\n\n; and more\n" + STL + "# the end\n",
        numbers=(*TETRA, *TETRA[:6]),
        faces=2,
    ),
    "stl without endsolid": Sample(
        ".stl", STL.replace("endsolid\n", ""), numbers=(*TETRA, *TETRA[:6]), faces=2
    ),
    "stl with split words": Sample(
        ".stl",
        STL.replace("end", "end ").replace("end  loop", "end\tloop"),
        numbers=(*TETRA, *TETRA[:6]),
        faces=2,
    ),
    "stl": Sample(
        ".stl",
        "solid a facet of vertex names\n"
        + "\tfacet normal 9.000000e+00 0 0\n\t\touter loop\n"
        + "\t\t\tvertex @ @ @\n" * 3
        + "\t\tendloop\n\tendfacet\nendsolid\nSOLID two\n"
        "  FACET NORMAL nan nan nan OUTER LOOP VERTEX @ @ @ vertex @ @ @\n"
        "vertex @ @ @ ENDLOOP ENDFACET\nENDSOLID two\n",
        numbers=(*TETRA, *TETRA[:6]),
        faces=2,
    ),
}
