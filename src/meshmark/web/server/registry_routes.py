"""Requests about the registry of copies: who got which."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request

from meshmark import __version__
from meshmark.cli.registry_option import open_registry
from meshmark.web.server.refusals import Refusal
from meshmark.web.server.schemas import CopyList, ErrorFields
from meshmark.web.server.settings import Settings

__all__ = ["registry_routes"]

registry_routes = APIRouter(
    prefix="/api/registry",
    tags=["registry"],
    responses={code: {"model": ErrorFields} for code in (400, 401, 403, 404, 409, 421, 422)},
)


@registry_routes.get("/copies")
def list_copies(
    request: Request,
    recipient: Annotated[
        str | None, Query(max_length=200, description="Copies of this recipient alone.")
    ] = None,
) -> CopyList:
    """List the copies of the registry."""
    settings: Settings = request.app.state.settings
    if settings.registry is None:
        raise Refusal(404, "this server has no registry")
    with open_registry(settings.registry) as opened:
        found = opened.copies(recipient=recipient or None)
    return CopyList(version=__version__, records=[each.to_dict() for each in found])
