"""`meshmark serve`: serve the page on which models are marked and checked."""

from __future__ import annotations

import contextlib
import os
import secrets
import socket
from pathlib import Path
from typing import Annotated

import typer

from meshmark.cli.output import say
from meshmark.cli.registry_option import RegistryIn, open_registry
from meshmark.errors import InputError, OutputError

__all__ = ["TOKEN_VARIABLE", "serve"]

TOKEN_VARIABLE = "MESHMARK_TOKEN"
"""Environment variable that holds the token, instead of a new one at each start."""
_TOKEN_BYTES, _SHORTEST_TOKEN = 24, 16


def serve(
    *,
    host: Annotated[
        str, typer.Option(help="Address to listen on; any but this computer's own needs a token.")
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port to listen on; 0 for any free one.")
    ] = 8000,
    key_dir: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of key files; ~/.config/meshmark/keys without it."),
    ] = None,
    registry: RegistryIn = None,
    name: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="Name by which the server is addressed, for example behind a proxy."
        ),
    ] = None,
    workers: Annotated[int, typer.Option(min=2, max=64, help="Jobs that run at once.")] = 2,
    max_upload: Annotated[int, typer.Option(min=1, metavar="MB", help="Most megabytes of an upload.")] = 512,
    job_memory: Annotated[int, typer.Option(min=256, metavar="MB", help="Most megabytes of a job.")] = 12288,
    job_time: Annotated[int, typer.Option(min=1, metavar="SECONDS", help="Most seconds of a job.")] = 3600,
    keep: Annotated[
        int, typer.Option(min=1, metavar="SECONDS", help="How long files of a finished job are kept.")
    ] = 3600,
) -> int:
    """Serve the page on which models are marked and checked.

    Models are uploaded to this program alone and removed after a while; keys stay in their folder. Bound to another
    address than this computer's own, the server asks for a token, which is printed once, or taken from the variable
    MESHMARK_TOKEN. It ends with Ctrl-C.
    """
    import uvicorn

    from meshmark.web.server.key_folder import KeyFolder
    from meshmark.web.server.service import make_service
    from meshmark.web.server.settings import MEGABYTE, Settings, default_key_folder, is_loopback

    folder = (key_dir or default_key_folder()).absolute()
    KeyFolder(folder).make()
    if registry:
        open_registry(registry).database.close()  # say now what is wrong with it
    token, is_new = (None, False) if is_loopback(host) else _token()
    settings = Settings(
        key_folder=folder,
        registry=registry or None,
        token=token,
        host=host,
        hosts=tuple(each.lower() for each in (*(name or ()), socket.gethostname())),
        workers=workers,
        upload_bytes=max_upload * MEGABYTE,
        job_bytes=job_memory * MEGABYTE,
        job_seconds=float(job_time),
        kept_seconds=float(keep),
    )
    listening = _listening(host, port)
    place = f"[{host}]" if ":" in host else host
    say(f"meshmark: serving on http://{place}:{listening.getsockname()[1]}/ with the keys in {folder}")
    if is_new:
        say(f"meshmark: the token of this start is {token}")
    config = uvicorn.Config(
        make_service(settings), log_level="warning", access_log=False, server_header=False, lifespan="on"
    )
    with contextlib.suppress(KeyboardInterrupt):  # raised again once all is closed
        uvicorn.Server(config).run(sockets=[listening])
    return 0


def _token() -> tuple[str, bool]:
    """Return the token, and whether it was made now and has to be shown; raises `InputError` for a short one."""
    given = os.environ.get(TOKEN_VARIABLE)
    if not given:
        return secrets.token_urlsafe(_TOKEN_BYTES), True
    if len(given) < _SHORTEST_TOKEN:
        raise InputError(
            f"the token in {TOKEN_VARIABLE} is of {len(given)} characters, expected {_SHORTEST_TOKEN} at least"
        )
    return given, False


def _listening(host: str, port: int) -> socket.socket:
    """Return a socket that listens; raises `OutputError` where it cannot."""
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family, backlog=128)
    except OSError as error:
        raise OutputError(f"cannot listen on {host}, port {port}: {error.strerror or error}") from None
