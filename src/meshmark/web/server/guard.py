"""What stands before every request: who may ask, from where, and how much may be sent.

Attack model. Whoever runs programs as the same user on this computer can read the keys anyway. Kept out are:
- other computers: without a token the server is bound to this computer alone; with one, every request to the API
  needs it, compared in constant time;
- pages of other sites in a browser on this computer: a POST or DELETE with a foreign Origin is refused (CSRF), and
  so is a Host header that is none of the server's names (DNS rebinding); no response may be framed, or read across
  sites;
- uploads without end: more bytes than the limit are refused while they arrive.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from meshmark.web.server.refusals import Refusal, refused
from meshmark.web.server.settings import MEGABYTE, Settings, is_loopback

__all__ = ["COOKIE", "Guard", "is_token", "session_value"]

COOKIE = "meshmark_session"
_OPEN = ("/api/session",)
_SAFE = ("GET", "HEAD", "OPTIONS")
_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


def is_token(given: str, token: str) -> bool:
    """Return whether a token is the server's, in constant time."""
    return hmac.compare_digest(given.encode("utf-8", "replace"), token.encode())


def session_value(token: str) -> str:
    """Return what the cookie of a browser holds that has presented the token: it does not give the token away."""
    return hmac.new(token.encode(), b"meshmark session", hashlib.sha256).hexdigest()


class Guard:
    """ASGI middleware: refuses what must not reach the application, and adds the headers of every response."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app, self.settings = app, settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        try:
            self._check(scope)
        except Refusal as refusal:
            await refused(refusal.status_code, refusal.detail)(scope, receive, sending)
            return
        await self.app(scope, _limited(receive, self.settings.upload_bytes), sending)

    def _check(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not _is_own_host(host, self.settings):
            raise Refusal(421, "this server does not go by the name in the Host header")
        if scope["method"] not in _SAFE:
            _check_origin(headers, host)
        length = headers.get("content-length", "0")
        if length.isdecimal() and int(length) > self.settings.upload_bytes:
            raise _too_large(self.settings.upload_bytes)
        path = str(scope["path"])
        if self.settings.token is not None and path.startswith("/api/") and path not in _OPEN:
            _check_token(headers, self.settings.token)


def _is_own_host(host: str, settings: Settings) -> bool:
    """Return whether a Host header names this server: by a name of its own, or by an address in a network."""
    try:
        name = (urlsplit(f"//{host}").hostname or "").rstrip(".").lower()
    except ValueError:
        return False
    if name in ("localhost", "127.0.0.1", "::1", settings.host.lower(), *settings.hosts):
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return not is_loopback(settings.host)


def _check_origin(headers: Headers, host: str) -> None:
    origin = headers.get("origin")
    try:
        foreign = origin is not None and urlsplit(origin).netloc.lower() != host.lower()
    except ValueError:  # no address at all
        foreign = True
    if foreign or headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
        raise Refusal(403, "this request comes from a page of another site")


def _check_token(headers: Headers, token: str) -> None:
    scheme, _, given = headers.get("authorization", "").partition(" ")
    if scheme.lower() == "bearer" and is_token(given.strip(), token):
        return
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        cookie = None
    if cookie is None or not is_token(cookie.value, session_value(token)):
        raise Refusal(401, "this server needs its token, expected the header Authorization: Bearer TOKEN")


def _too_large(most: int) -> Refusal:
    return Refusal(
        413, f"the upload is larger than {most / MEGABYTE:,.0f} MB, the most that this server takes"
    )


def _limited(receive: Receive, most: int) -> Receive:
    """Return a channel of the body that refuses to hand out more bytes than `most`."""
    seen = 0

    async def limited() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > most:
            raise _too_large(most)
        return message

    return limited
