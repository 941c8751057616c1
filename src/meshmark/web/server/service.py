"""The application: its routes, and what lives as long as it does."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from fastapi import FastAPI

from meshmark import __version__
from meshmark.web.server.guard import Guard
from meshmark.web.server.job_folders import job_folders
from meshmark.web.server.job_queue import JobQueue
from meshmark.web.server.job_routes import job_routes
from meshmark.web.server.key_folder import KeyFolder
from meshmark.web.server.key_routes import key_routes
from meshmark.web.server.page_routes import page_routes, serve_pages
from meshmark.web.server.refusals import add_handlers
from meshmark.web.server.registry_routes import registry_routes
from meshmark.web.server.settings import Settings

__all__ = ["make_service"]

_ABOUT = (
    "Models are marked and checked in jobs: `POST /api/jobs` with a model begins one, `GET /api/jobs/{job}` tells "
    "what it is at, and its files are downloaded. `result` is what the command line prints with `--json`."
)


def make_service(settings: Settings, home: Path | None = None) -> FastAPI:
    """Return the application. home: where the folder of all jobs is made, that of temporary files if None."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        with job_folders(home) as folder:
            app.state.folder = folder
            async with app.state.queue:
                yield

    app = FastAPI(
        title="meshmark",
        version=__version__,
        description=_ABOUT,
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        docs_url=None,  # its page loads scripts from elsewhere
        redoc_url=None,
    )
    app.state.settings, app.state.keys = settings, KeyFolder(settings.key_folder)
    app.state.queue = JobQueue(settings)
    for routes in (job_routes, key_routes, registry_routes, page_routes):
        app.include_router(routes)
    serve_pages(app)
    add_handlers(app)
    app.add_middleware(Guard, settings=settings)
    return app
