"""From an upload to a job: its files stored in a folder of its own, its command line made."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fastapi import UploadFile

from meshmark.errors import InputError
from meshmark.web.server.job_folders import remove_folder
from meshmark.web.server.orders import OUT, Action, Order, check_order, command_of
from meshmark.web.server.settings import Settings
from meshmark.web.server.uploads import model_among, put_in_places, stored
from meshmark.web.server.web_job import WebJob

__all__ = ["Uploads", "make_job"]

_ID_BYTES = 18


@dataclass(frozen=True, kw_only=True)
class Uploads:
    """The uploaded files: the model and what it refers to, a certificate, the original and what it refers to."""

    files: Sequence[UploadFile]
    certificate: UploadFile | None
    original: Sequence[UploadFile]


def make_job(
    uploads: Uploads,
    action: Action,
    key: Path,
    options: dict[str, str | None],
    *,
    settings: Settings,
    home: Path,
) -> WebJob:
    """Store uploads and return the job; raises `InputError` where they cannot be used, and leaves nothing behind.

    key: the key file. options: of the command line. home: folder of all jobs.
    """
    identity = secrets.token_urlsafe(_ID_BYTES)
    folder = home / identity
    folder.mkdir(mode=0o700)
    try:
        (folder / OUT).mkdir()
        model = _model(uploads.files, folder / "in")
        order = Order(
            action=action,
            model=model.relative_to(folder),
            key=key.absolute(),
            certificate=_one(uploads.certificate, folder / "certificate", folder),
            original=_model(uploads.original, folder / "original").relative_to(folder)
            if uploads.original
            else None,
            options=options,
        )
        check_order(order, registry=settings.registry is not None)
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
        return WebJob(
            id=identity,
            folder=folder,
            order=order,
            command=command_of(order),
            large=size > settings.small_bytes,
        )
    except BaseException:
        remove_folder(folder)
        raise


def _model(uploads: Sequence[UploadFile], folder: Path) -> Path:
    paths = [stored(each.file, each.filename, folder) for each in uploads]
    if not paths:
        raise InputError("no file was uploaded, expected a model")
    model = model_among(paths)
    put_in_places(model, [path for path in paths if path != model])
    return model


def _one(upload: UploadFile | None, folder: Path, home: Path) -> Path | None:
    return None if upload is None else stored(upload.file, upload.filename, folder).relative_to(home)
