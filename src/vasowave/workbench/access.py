"""Who may ask: this machine alone, through the address that was printed, with bodies of a bounded size."""

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LARGEST_FILE = 4 << 30
"""Bytes of one file that is dropped; hours of a recording as text are a tenth of it."""

LARGEST_ACTION = 4 << 20
"""Bytes of any other request; the edits of all beats of two hours are a tenth of it."""

_CONNECTIONS = 200  # a browser opens six
_PATIENCE = 20.0  # s that a connection may take until its first request is there
_PAGE = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
_ALWAYS = "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
PAGE_POLICY = _PAGE + _ALWAYS
REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data:; "
    f"sandbox allow-scripts allow-popups allow-downloads; {_ALWAYS}"
)
"""A report brings its scripts along; in a sandbox it is no page of the workbench's origin, and can ask it nothing."""

_HEADERS = {
    "cache-control": "no-store",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
}


class TooLargeError(Exception):
    """A body is larger than allowed."""


class Guarded:
    """An application behind its token; everything else is refused before the application sees it.

    Parameters
    ----------
    app : ASGI application
        Gets paths without the token.
    token : str
        The first part of every path.
    port : int
    """

    def __init__(self, app: App, token: str, port: int) -> None:
        self.app, self.token = app, token
        self.hosts = {f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost")}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            if scope["type"] == "websocket":
                await send({"type": "websocket.close", "code": 1008})
            return
        refused = self._refused(scope)
        if refused is not None:
            await _plain(send, *refused)
            return
        limit = LARGEST_FILE if scope["method"] == "PUT" else LARGEST_ACTION

        async def counted() -> MutableMapping[str, Any]:
            nonlocal limit
            message = await receive()
            limit -= len(message.get("body", b""))
            if limit < 0:
                raise TooLargeError
            return message

        async def sent(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                given = {name.lower() for name, _ in message.get("headers", ())}
                more = _HEADERS | {"content-security-policy": PAGE_POLICY}
                message["headers"] = [*message.get("headers", ()), *(
                    (name.encode(), text.encode()) for name, text in more.items() if name.encode() not in given
                )]  # fmt: skip
            await send(message)

        inner = dict(scope) | {"path": scope["path"][len(self.token) + 1 :], "root_path": "", "raw_path": None}
        await self.app(inner, counted, sent)

    def _refused(self, scope: Scope) -> tuple[int, str] | None:
        """Return status and sentence of what may not be asked."""
        headers: dict[bytes, list[bytes]] = {}
        for name, value in scope["headers"]:
            headers.setdefault(name, []).append(value)
        (host, *more), origins = headers.get(b"host", [b""]), headers.get(b"origin", [])
        if more or host not in self.hosts:
            return 421, "The workbench answers on this machine alone."
        if any(origin != b"http://" + host for origin in origins):
            return 403, "Another page may ask nothing of the workbench."
        if headers.get(b"sec-fetch-site", [b"none"])[0] not in (b"same-origin", b"none"):
            return 403, "Another page may ask nothing of the workbench."
        if scope["method"] not in ("GET", "HEAD") and not origins:
            return 403, "A request that changes something says which page it comes from (Origin)."
        given, slash, _ = scope["path"][1:].partition("/")
        if not (slash and hmac.compare_digest(given.encode("utf-8", "replace"), self.token.encode())):
            return 404, "Open the address that `vasowave open` printed: it carries a key, which is another each time."
        return self._too_large(scope["method"], headers.get(b"content-length", []))

    @staticmethod
    def _too_large(method: str, lengths: list[bytes]) -> tuple[int, str] | None:
        most = LARGEST_FILE if method == "PUT" else LARGEST_ACTION
        if any(int(length) > most for length in lengths if length.isdigit()):
            return 413, f"This is too large: at most {most >> 20} MiB."
        return None


async def _plain(send: Send, status: int, text: str) -> None:
    """Send a sentence."""
    body = text.encode()
    headers = {"content-type": "text/plain; charset=utf-8", "content-length": str(len(body)), "connection": "close"}
    pairs = [(name.encode(), value.encode()) for name, value in (headers | _HEADERS).items()]
    await send({"type": "http.response.start", "status": status, "headers": pairs})
    await send({"type": "http.response.body", "body": body})


class Patient(H11Protocol):
    """Connections, at most so many at once; one that asks nothing is closed after a while."""

    def connection_made(self, transport: Any) -> None:
        """Take a connection, or close it at once."""
        super().connection_made(transport)
        self.waiting = self.loop.call_later(_PATIENCE, self._close_idle)
        if len(self.connections) > _CONNECTIONS:
            transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        self.waiting.cancel()
        super().connection_lost(exc)

    def _close_idle(self) -> None:
        if self.cycle is None:
            self.transport.abort()
