"""Requests that are refused: one sentence, in the form in which the command line's JSON has errors."""

from __future__ import annotations

import re
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from meshmark.errors import MeshmarkError, OutputError, RegistryError

__all__ = ["Refusal", "add_handlers", "error_fields", "refused"]

_KINDS = {
    400: "usage", 401: "unauthorized", 403: "forbidden", 404: "not_found", 405: "usage", 409: "conflict",
    413: "too_large", 421: "forbidden", 422: "usage", 429: "busy",
}  # fmt: skip
_WORDS = {404: "there is nothing at this address", 405: "this address does not take this method"}
# Errors of the product that are not about what the client sent in this very request.
_STATUS = {OutputError.kind: 409, RegistryError.kind: 409}


class Refusal(HTTPException):
    """A request that is refused; raised anywhere under the application."""

    def __init__(self, status: int, sentence: str, file: str | None = None) -> None:
        super().__init__(status, sentence)
        self.file = file


def error_fields(kind: str, message: str, file: str | None = None) -> dict[str, Any]:
    """Return the JSON of an error."""
    return {"error": {"kind": kind, "message": message, "file": file}}


def refused(status: int, sentence: str, kind: str | None = None, file: str | None = None) -> JSONResponse:
    """Return the response that refuses a request."""
    return JSONResponse(error_fields(kind or _KINDS.get(status, "usage"), sentence, file), status)


def add_handlers(app: FastAPI) -> None:
    """Let every refusal of an application have the one form."""
    app.add_exception_handler(HTTPException, _on_http)
    app.add_exception_handler(RequestValidationError, _on_invalid)
    app.add_exception_handler(MeshmarkError, _on_error)


async def _on_http(request: Request, error: Exception) -> JSONResponse:
    status = getattr(error, "status_code", 400)
    sentence = str(getattr(error, "detail", ""))
    if not isinstance(error, Refusal):
        sentence = _WORDS.get(status, sentence[:1].lower() + sentence[1:])
    response = refused(status, sentence, file=getattr(error, "file", None))
    response.headers.update(getattr(error, "headers", None) or {})
    if status == 405:
        response.headers["Allow"] = ", ".join(_methods(request))
    return response


def _methods(request: Request) -> list[str]:
    """Return the methods that the address of a request takes, whichever route has them."""
    for path, methods in request.app.openapi()["paths"].items():
        if re.fullmatch(re.sub(r"{\w+}", "[^/]+", path), request.url.path):
            return sorted(method.upper() for method in methods)
    return ["GET"]  # the page and its files


async def _on_invalid(_: Request, error: Exception) -> JSONResponse:
    found = error.errors()[0] if isinstance(error, RequestValidationError) else {"loc": (), "msg": "invalid"}
    where = ".".join(str(part) for part in found["loc"][1:])
    message = str(found["msg"]).removeprefix("Value error, ")
    return refused(422, f"{where}: {message[:1].lower()}{message[1:]}" if where else message)


async def _on_error(_: Request, error: Exception) -> JSONResponse:
    kind = getattr(error, "kind", "error")
    return refused(_STATUS.get(kind, 422), str(error), kind, getattr(error, "file", None))
