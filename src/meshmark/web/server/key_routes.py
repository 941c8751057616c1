"""Requests about keys: listed by label and public fingerprint, and made; never handed out."""

from __future__ import annotations

from fastapi import APIRouter, Request

from meshmark.web.server.key_folder import KeyFolder, ListedKey
from meshmark.web.server.schemas import ErrorFields, KeyFields, NewKey

__all__ = ["key_routes"]

key_routes = APIRouter(
    prefix="/api/keys",
    tags=["keys"],
    responses={code: {"model": ErrorFields} for code in (400, 401, 403, 409, 413, 421, 422)},
)


@key_routes.get("")
def list_keys(request: Request) -> list[KeyFields]:
    """List the keys of the folder of keys."""
    return [_fields(each) for each in _folder(request).listed()]


@key_routes.post("", status_code=201)
def make_key(request: Request, new: NewKey) -> KeyFields:
    """Make a new key; it stays in the folder of keys."""
    return _fields(_folder(request).create(new.label))


def _folder(request: Request) -> KeyFolder:
    folder: KeyFolder = request.app.state.keys
    return folder


def _fields(key: ListedKey) -> KeyFields:
    return KeyFields(label=key.label, fingerprint=key.fingerprint, problem=key.problem)
