"""The page and its files, and what it asks first: what the server is, and a session for its token."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import FileResponse
from fastapi.staticfiles import StaticFiles

from meshmark import __version__
from meshmark.io.formats import FORMATS, OTHER_NAMES
from meshmark.web.server.guard import COOKIE, is_token, session_value
from meshmark.web.server.refusals import Refusal
from meshmark.web.server.schemas import ErrorFields, Server, Session
from meshmark.web.server.settings import Settings

__all__ = ["page_routes", "serve_pages"]

_WEB = Path(__file__).resolve().parents[1]
_PAGES = Path(__file__).resolve().parent / "pages"
_ERRORS: dict[int | str, dict[str, Any]] = {
    code: {"model": ErrorFields} for code in (400, 401, 403, 413, 421, 422)
}

page_routes = APIRouter(tags=["server"], responses=_ERRORS)


@page_routes.get("/", include_in_schema=False)
async def show_page() -> FileResponse:
    """Return the page."""
    return FileResponse(_PAGES / "index.html")


@page_routes.get("/api/server")
async def describe(request: Request) -> Server:
    """Return what the server is and takes."""
    settings: Settings = request.app.state.settings
    return Server(
        version=__version__,
        registry=settings.registry is not None,
        upload_bytes=settings.upload_bytes,
        kept_seconds=settings.kept_seconds,
        extensions=[*(end for entry in FORMATS.values() for end in entry.extensions), *OTHER_NAMES],
    )


@page_routes.post("/api/session", status_code=204)
async def open_session(request: Request, session: Session) -> Response:
    """Let a browser in that presents the token; a cookie that scripts cannot read remembers it."""
    settings: Settings = request.app.state.settings
    response = Response(status_code=204)
    if settings.token is None:
        return response
    if not is_token(session.token, settings.token):
        raise Refusal(401, "this is not the token of this server")
    response.set_cookie(COOKIE, session_value(settings.token), httponly=True, samesite="strict")
    return response


def serve_pages(app: FastAPI) -> None:
    """Serve the files of the page and of the viewer."""
    app.mount("/pages", StaticFiles(directory=_PAGES), name="pages")
    app.mount("/viewer", StaticFiles(directory=_WEB / "viewer", check_dir=False), name="viewer")
