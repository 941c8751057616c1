"""Arguments and options that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

__all__ = [
    "AsJson",
    "Bits",
    "CertificateIn",
    "CertificateNeeded",
    "Force",
    "KeyFile",
    "Layers",
    "LikeEmbedLayers",
    "LikeEmbedPayload",
    "LikeEmbedStrength",
    "LikeEmbedTolerance",
    "ModelFormat",
    "ModelFormatIn",
    "ModelIn",
    "ModelOut",
    "OriginalIn",
    "Picture",
    "ReportOut",
    "Search",
    "Strength",
    "Tolerance",
]


class Strength(StrEnum):
    """How far the mark may move the surface, RMS over the bounding box's diagonal."""

    subtle = "subtle"
    standard = "standard"
    strong = "strong"


class Bits(StrEnum):
    """How many bits the id has; 0: there is none."""

    long = "64"
    short = "32"
    none = "0"


class Layers(StrEnum):
    """What to embed."""

    both = "both"
    ownership = "ownership"
    authentication = "authentication"


class Tolerance(StrEnum):
    """What counts as a change."""

    strict = "strict"
    default = "default"
    tolerant = "tolerant"
    web = "web"


class Search(StrEnum):
    """How long to look for a mark."""

    quick = "quick"
    wide = "wide"


class ModelFormat(StrEnum):
    """The format of a model, as `FORMATS` names it."""

    off = "off"
    obj = "obj"
    ply = "ply"
    stl = "stl"
    glb = "glb"
    gltf = "gltf"
    threemf = "3mf"


ModelIn = Annotated[
    Path,
    typer.Argument(
        metavar="IN",
        help="Model: .off .obj .ply .stl .glb .gltf .3mf, each also .gz; - for standard input, with --format.",
    ),
]
ModelFormatIn = Annotated[
    ModelFormat | None,
    typer.Option("--format", help="Format of the model on standard input, also gzipped."),
]
Force = Annotated[
    bool, typer.Option("--force", help="Replace existing files; keys and inputs are never replaced.")
]
ForceKeyed = Annotated[
    bool,
    typer.Option(
        "--force",
        help="Replace existing files (keys and inputs never), and take a key file that other users can read.",
    ),
]
ForceKey = Annotated[bool, typer.Option("--force", help="Take a key file that other users can read.")]
ModelOut = Annotated[
    Path,
    typer.Argument(metavar="OUT", help="File to write; in the format of IN unless its name says otherwise."),
]
KeyFile = Annotated[
    Path, typer.Option("--key", metavar="KEYFILE", help="Key file made by `meshmark keygen`.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of words.")]
Diagnose = Annotated[
    bool,
    typer.Option(
        "--diagnose",
        help="Also tell carriers, lock, exact bounds and time: for research, never to strangers (docs/answers.md).",
    ),
]
Picture = Annotated[
    Path | None, typer.Option("--picture", metavar="OUT.png", help="Also draw the model as a PNG picture.")
]
ReportOut = Annotated[
    Path | None,
    typer.Option(
        "--report", metavar="OUT.html", help="Also write a page with a view in 3D, pictures and a table."
    ),
]
_CERTIFICATE = typer.Option("--certificate", metavar="CERT", help="The certificate made at embedding.")
CertificateIn = Annotated[Path | None, _CERTIFICATE]
CertificateNeeded = Annotated[Path, _CERTIFICATE]
OriginalIn = Annotated[
    Path | None,
    typer.Option("--original", metavar="MODEL", help="The unmarked original, instead of a certificate."),
]
# What commands that make many marks take as `embed` does, and leave to its help.
_AS_EMBED = "As `embed` takes it."
LikeEmbedStrength = Annotated[Strength, typer.Option(help=_AS_EMBED)]
LikeEmbedLayers = Annotated[Layers | None, typer.Option(help=_AS_EMBED)]
LikeEmbedPayload = Annotated[str | None, typer.Option(metavar="miniature|none|FILE", help=_AS_EMBED)]
LikeEmbedTolerance = Annotated[Tolerance | None, typer.Option(help=_AS_EMBED)]
