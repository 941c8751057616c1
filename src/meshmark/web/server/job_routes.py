"""Requests about jobs: what is uploaded becomes a job, which is looked at, cancelled, and its files downloaded."""

from __future__ import annotations

import asyncio
import math
from typing import Annotated

from fastapi import APIRouter, File, Form, Query, Request, Response, UploadFile
from fastapi.responses import FileResponse, JSONResponse

from meshmark.cli.options import Bits, Layers, Search, Strength, Tolerance
from meshmark.coding.message import parse_id
from meshmark.web.server.job_queue import JobQueue
from meshmark.web.server.key_folder import LABEL
from meshmark.web.server.new_jobs import Uploads, make_job
from meshmark.web.server.orders import Action
from meshmark.web.server.refusals import Refusal
from meshmark.web.server.schemas import DownloadFields, ErrorFields, JobFields
from meshmark.web.server.settings import Settings
from meshmark.web.server.web_job import State, WebJob

__all__ = ["job_routes"]

job_routes = APIRouter(
    prefix="/api/jobs",
    tags=["jobs"],
    responses={code: {"model": ErrorFields} for code in (400, 401, 403, 404, 409, 413, 421, 422, 429)},
)
_LONGEST_WAIT = 25.0
# What the answer to a new job leads to, for readers of the OpenAPI description.
_LINKS = {
    name: {"operationId": name, "parameters": {"job": "$response.body#/id"}}
    for name in ("show_job", "show_result", "show_view", "cancel_job")
}


@job_routes.post("", status_code=202, operation_id="begin_job", responses={202: {"links": _LINKS}})
async def begin_job(
    request: Request,
    *,
    action: Annotated[Action, Form(description="What to do with the model.")],
    key: Annotated[str, Form(pattern=LABEL, description="Label of the key.")],
    files: Annotated[
        list[UploadFile], File(min_length=1, description="The model, and the files that it refers to.")
    ],
    certificate: Annotated[UploadFile | None, File(description="The certificate made at embedding.")] = None,
    original: Annotated[
        list[UploadFile] | None, File(description="The unmarked original, instead of a certificate.")
    ] = None,
    id: Annotated[
        str | None, Form(max_length=40, description="embed: 16 hexadecimal digits, 8 of 32 bits.")
    ] = None,
    bits: Annotated[Bits | None, Form(description="embed: of the id, 0 for a mark without one.")] = None,
    strength: Annotated[Strength | None, Form(description="embed")] = None,
    layers: Annotated[Layers | None, Form(description="embed")] = None,
    tolerance: Annotated[Tolerance | None, Form(description="embed")] = None,
    recompress: Annotated[bool, Form(description="embed: compress the result as the model is.")] = False,
    recipient: Annotated[
        str | None, Form(max_length=200, description="embed, with a registry: to whom the copy goes.")
    ] = None,
    search: Annotated[Search | None, Form(description="extract, trace")] = None,
    time_limit: Annotated[float | None, Form(gt=0, description="extract, trace: seconds.")] = None,
) -> JobFields:
    """Begin a job: an action of the command line on the uploaded model."""
    queue, settings = _queue(request), _settings(request)
    queue.check_room()
    if time_limit is not None and not math.isfinite(time_limit):
        raise Refusal(422, "time_limit: expected a number of seconds")
    if id:
        parse_id(id, int(bits or Bits.long))
    options = {
        "id": id or None,
        "bits": bits,
        "strength": strength,
        "layers": layers,
        "tolerance": tolerance,
        "recompress": "" if recompress else None,
        "to": recipient or None,
        "search": search,
        "time-limit": None if time_limit is None else str(time_limit),
    }
    uploads = Uploads(files=files, certificate=certificate, original=original or [])
    job = await asyncio.to_thread(
        make_job, uploads, action, request.app.state.keys.file_of(key), options, settings=settings,
        home=request.app.state.folder,
    )  # fmt: skip
    queue.submit(job)
    return _fields(job, queue)


@job_routes.get("/{job}", operation_id="show_job")
async def show_job(
    request: Request,
    job: str,
    wait: Annotated[
        float,
        Query(ge=0, le=_LONGEST_WAIT, description="Answer when something changes, or after these seconds."),
    ] = 0.0,
) -> JobFields:
    """Return what a job is at, and what came of it."""
    queue = _queue(request)
    found = queue.find(job)
    before, left = (found.state, found.stage), wait
    while left > 0 and not found.is_over and (found.state, found.stage) == before:
        await asyncio.sleep(0.1)
        left -= 0.1
    return _fields(found, queue)


@job_routes.get(
    "/{job}/result", operation_id="show_result", responses={200: {"content": {"application/json": {}}}}
)
async def show_result(request: Request, job: str) -> Response:
    """Return exactly what the command line prints with --json; an error has the status 422."""
    found = _queue(request).find(job)
    if not found.is_over or found.answer is None:
        raise Refusal(409, f"the job has no result, it is {found.state.value}")
    return JSONResponse(found.answer, 422 if found.error else 200)


@job_routes.delete("/{job}", status_code=204, operation_id="cancel_job")
async def cancel_job(request: Request, job: str) -> Response:
    """Cancel a job, whatever it is at, and remove its files."""
    queue = _queue(request)
    queue.cancel(queue.find(job))
    return Response(status_code=204)


@job_routes.get("/{job}/files/{name}", response_class=FileResponse)
async def download(request: Request, job: str, name: str) -> Response:
    """Return a file that a job made, to be saved."""
    found = _queue(request).find(job)
    file = found.downloads.get(name) if found.state is State.done else None
    if file is None:
        raise Refusal(404, "the job made no such file")
    return FileResponse(
        file.path,
        filename=file.name,
        media_type="application/octet-stream",
        headers={"Content-Security-Policy": "sandbox"},
    )


@job_routes.get(
    "/{job}/view", operation_id="show_view", responses={200: {"content": {"application/json": {}}}}
)
async def show_view(request: Request, job: str) -> Response:
    """Return the data of the interactive view."""
    found = _queue(request).find(job)
    if found.view is None or found.state is not State.done:
        raise Refusal(404, "the job has no view")
    return FileResponse(found.view, media_type="application/json")


def _queue(request: Request) -> JobQueue:
    queue: JobQueue = request.app.state.queue
    return queue


def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


def _fields(job: WebJob, queue: JobQueue) -> JobFields:
    place = f"/api/jobs/{job.id}"
    done = job.state is State.done
    return JobFields.model_validate(
        {
            "id": job.id,
            "action": job.order.action,
            "state": job.state,
            "stage": job.stage,
            "seconds": round(job.seconds, 2),
            "position": queue.position(job),
            "exit_code": job.exit_code,
            "result": job.answer if done else None,
            "words": job.words if done else "",
            "remarks": job.remarks if done else [],
            "error": job.error,
            "downloads": [
                DownloadFields(
                    kind=each.kind, name=each.name, bytes=each.bytes, url=f"{place}/files/{each.name}"
                )
                for each in (job.downloads.values() if done else ())
            ],
            "view": f"{place}/view" if done and job.view is not None else None,
        }
    )
