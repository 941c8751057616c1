"""The JSON of the server's answers, as its OpenAPI description has it."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, Field

from meshmark.web.server.key_folder import LABEL
from meshmark.web.server.orders import Action
from meshmark.web.server.web_job import State

__all__ = [
    "CopyList",
    "DownloadFields",
    "ErrorFields",
    "JobFields",
    "KeyFields",
    "NewKey",
    "Server",
    "Session",
]


class ErrorDetail(BaseModel):
    """What was wrong."""

    kind: str = Field(description="Names the kind of error, as on the command line.")
    message: str = Field(description="One sentence.")
    file: str | None = Field(description="The file that it is about.")


class ErrorFields(BaseModel):
    """A request that was refused."""

    error: ErrorDetail


class KeyFields(BaseModel):
    """What is told of a key."""

    label: str
    fingerprint: str | None = Field(
        description="Public: 16 hexadecimal digits; null where the file cannot be used."
    )
    problem: str | None = Field(default=None, description="Why the file cannot be used.")


class NewKey(BaseModel):
    """A key to make."""

    label: Annotated[
        str, Field(pattern=LABEL, description="What the key is called; its file is named after it.")
    ]


class DownloadFields(BaseModel):
    """A file that a job made."""

    kind: str = Field(description="model, certificate, report, map.")
    name: str
    bytes: int
    url: str


class JobFields(BaseModel):
    """A job."""

    id: str
    action: Action
    state: State
    stage: str = Field(description="What the job is doing, in words.")
    seconds: float = Field(description="For how long it has been worked on.")
    position: int | None = Field(description="Jobs before this one, while it is queued.")
    exit_code: int | None = Field(
        description="Of the command line: 0 yes, 1 no, 3 inconclusive, 2 and 4 errors."
    )
    result: dict[str, Any] | None = Field(description="What the command line prints with --json.")
    words: str = Field(description="The answer in plain words.")
    remarks: list[str]
    error: ErrorDetail | None
    downloads: list[DownloadFields]
    view: str | None = Field(description="Where the data of the interactive view is.")


class Server(BaseModel):
    """What the server is."""

    version: str
    registry: bool = Field(description="Whether there is a registry of copies.")
    upload_bytes: int = Field(description="The most that one upload may hold.")
    kept_seconds: float = Field(description="How long the files of a job are kept.")
    extensions: list[str] = Field(description="Of the models that are read.")


class Session(BaseModel):
    """The token of a server that is bound to more than its own computer."""

    token: Annotated[str, Field(min_length=1, max_length=200)]


class CopyList(BaseModel):
    """Copies of the registry, as `meshmark registry list --json` prints them."""

    version: str
    input: None = None
    outputs: dict[str, str] = {}
    key: None = None
    records: list[dict[str, Any]]
