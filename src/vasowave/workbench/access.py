"""Who may ask: this machine alone, through the address that was printed, with bodies of a bounded size."""

import hmac
import html
import secrets
from asyncio import TimerHandle, wait_for
from collections.abc import Awaitable, Callable, MutableMapping
from pathlib import Path
from time import monotonic
from typing import Any
from urllib.parse import quote

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
_PATIENCE = 20.0  # s that a connection may take until a request is there, or more of its body, or of its answer goes
_BODY_RATE = 4096  # bytes a second of a body after that; a browser on the same machine sends a thousand times as many
_PAGE = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
_ALWAYS = "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
PAGE_POLICY = _PAGE + _ALWAYS
REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data:; "
    f"sandbox allow-scripts allow-popups allow-downloads; {_ALWAYS}"
)
"""A report brings its scripts along; in a sandbox it has another origin and can ask the workbench nothing."""

_REPORT = "report/"
_ICON = Path(__file__).parent / "page" / "mark.svg"
_HEADERS = {
    "cache-control": "no-store",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
}


class TooLargeError(Exception):
    """A body is larger than allowed."""


class TooSlowError(Exception):
    """A body does not come, or trickles."""


class Guarded:
    """An application behind its token; everything else is refused before the application sees it.

    A report stands behind another one, `report_token`, with which nothing else can be asked: its scripts can read the
    address that they stand at.

    Parameters
    ----------
    app : ASGI application
        Gets paths without the token.
    token : str
        The first part of every path.
    port : int
    """

    def __init__(self, app: App, token: str, port: int) -> None:
        self.app: App = app
        self.token: str = token
        self.report_token: str = secrets.token_urlsafe(24)
        self.hosts: set[bytes] = {f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost")}
        self._tickets: dict[str, tuple[str, Callable[[], None]]] = {}

    def ticket(self, desk: str, used: Callable[[], None]) -> str:
        """Return a path that leads to the page's desk (the address behind its ``#``) once; `used` is called then.

        A program is started with it in place of the token, which stays out of the list of processes.
        """
        ticket = secrets.token_urlsafe(24)
        self._tickets[ticket] = desk, used
        return f"/{ticket}/"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            if scope["type"] == "websocket":
                await send({"type": "websocket.close", "code": 1008})
            return
        headers: dict[bytes, list[bytes]] = {}
        for name, value in scope["headers"]:
            headers.setdefault(name, []).append(value)
        elsewhere = self._from_elsewhere(headers)
        if elsewhere is None and scope["method"] == "GET" and (page := self._page_of_ticket(scope["path"])):
            await _plain(send, 200, page, "text/html")
            return
        if elsewhere is None and scope["method"] == "GET" and scope["path"] == "/favicon.ico":
            # A browser asks for it without the key, before it has read which icon the page names.
            await _plain(send, 200, _ICON.read_text(encoding="utf-8"), "image/svg+xml")
            return
        refused = elsewhere or self._refused(scope, headers)
        if refused is not None:
            await _plain(send, *refused)
            return
        token, _, subpath = scope["path"][1:].partition("/")
        if token == self.token and subpath.startswith(_REPORT):
            await _plain(send, 307, "", location=f"/{self.report_token}/{quote(subpath)}")
            return
        limit, received, waited, is_incomplete = _most(scope["method"]), 0, 0.0, True

        async def counted() -> MutableMapping[str, Any]:
            nonlocal received, waited, is_incomplete
            start, patience = monotonic(), _PATIENCE + received / _BODY_RATE - waited
            try:
                message = await wait_for(receive(), min(_PATIENCE, patience) if is_incomplete else None)
            except TimeoutError:
                raise TooSlowError from None
            waited += monotonic() - start
            received, is_incomplete = received + len(message.get("body", b"")), message.get("more_body", False)
            if received > limit:
                raise TooLargeError
            return message

        async def sent(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                names = {name.lower() for name, _ in message.get("headers", ())}
                extra_headers = _HEADERS | {"content-security-policy": PAGE_POLICY}
                message["headers"] = [*message.get("headers", ()), *(
                    (name.encode(), text.encode()) for name, text in extra_headers.items() if name.encode() not in names
                )]  # fmt: skip
            await send(message)

        inner = dict(scope) | {"path": f"/{subpath}", "root_path": "", "raw_path": None}
        await self.app(inner, counted, sent)

    def _from_elsewhere(self, headers: dict[bytes, list[bytes]]) -> tuple[int, str] | None:
        """Return status and sentence of what another machine's name or another page asks."""
        (host, *extra_hosts), origins = headers.get(b"host", [b""]), headers.get(b"origin", [])
        if extra_hosts or host not in self.hosts:
            return 421, "The workbench answers on this machine alone."
        if any(origin != b"http://" + host for origin in origins):
            return 403, "Another page may ask nothing of the workbench."
        return None

    def _page_of_ticket(self, path: str) -> str:
        """Return the page that goes on from a ticket, which is used up then; nothing for what is none.

        The page, not a redirection: only what this server's own page leads to counts as of the same site.
        """
        address = path.encode("utf-8", "replace")
        ticket = next(
            (candidate for candidate in self._tickets if hmac.compare_digest(address, f"/{candidate}/".encode())), None
        )
        if ticket is None:
            return ""
        desk, used = self._tickets.pop(ticket)
        used()
        return redirection(f"/{self.token}/{desk}")

    def _refused(self, scope: Scope, headers: dict[bytes, list[bytes]]) -> tuple[int, str] | None:
        """Return status and sentence of what may not be asked."""
        if headers.get(b"sec-fetch-site", [b"none"])[0] not in (b"same-origin", b"none"):
            return 403, "Another page may ask nothing of the workbench."
        if scope["method"] not in ("GET", "HEAD") and b"origin" not in headers:
            return 403, "A request that changes something says which page it comes from (Origin)."
        key, slash, subpath = scope["path"][1:].partition("/")
        of_report = scope["method"] in ("GET", "HEAD") and subpath.startswith(_REPORT)
        tokens = [self.token, *([self.report_token] if of_report else [])]
        if not slash or not any(
            hmac.compare_digest(key.encode("utf-8", "replace"), token.encode()) for token in tokens
        ):
            return 404, "Open the address that `vasowave open` printed: it carries a key, which is another each time."
        return self._too_large(scope["method"], headers.get(b"content-length", []))

    @staticmethod
    def _too_large(method: str, lengths: list[bytes]) -> tuple[int, str] | None:
        limit = _most(method)
        if any(int(length) > limit for length in lengths if length.isdigit()):
            return 413, f"This is too large: at most {limit >> 20} MiB."
        return None


def _most(method: str) -> int:
    return LARGEST_FILE if method == "PUT" else LARGEST_ACTION


def redirection(address: str) -> str:
    """Return a page that leads to an address at once."""
    target = html.escape(address)
    head = '<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer">'
    return f'{head}<meta http-equiv="refresh" content="0;url={target}"><a href="{target}">Open the workbench</a>'


async def _plain(send: Send, status: int, text: str, kind: str = "text/plain", **extra_headers: str) -> None:
    """Send a sentence, or a page, with `extra_headers`."""
    body = text.encode()
    headers = {
        "content-type": f"{kind}; charset=utf-8",
        "content-security-policy": PAGE_POLICY,
        "content-length": str(len(body)),
        "connection": "close",
        **extra_headers,
    }
    pairs = [(name.encode(), value.encode()) for name, value in (headers | _HEADERS).items()]
    await send({"type": "http.response.start", "status": status, "headers": pairs})
    await send({"type": "http.response.body", "body": body})


class Patient(H11Protocol):
    """Connections, at most so many at once; one that asks nothing, or takes no answer, is closed after a while.

    One too many takes the place of the oldest that never asked anything.
    """

    begun: float = 0.0
    waiting: TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Take a connection, or close it at once."""
        super().connection_made(transport)
        self._wait(self._close_idle)
        self.begun = self.loop.time()
        if len(self.connections) > _CONNECTIONS:
            connections = (
                connection
                for connection in self.connections
                if isinstance(connection, Patient) and connection is not self
            )
            silent = [connection for connection in connections if connection.cycle is None]
            closed = min(silent, key=lambda connection: connection.begun, default=self)
            closed.transport.abort()
            self.connections.discard(closed)  # which would be chosen again before it hears of its end

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        self._wait(self._close_idle)
        super().on_response_complete()

    def pause_writing(self) -> None:
        """Wait until the other side has taken some of what was sent."""
        self._wait(self.transport.abort)
        super().pause_writing()

    def resume_writing(self) -> None:
        """Send on."""
        self._wait(self._close_idle)
        super().resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        super().connection_lost(exc)
        self._wait(None)

    def _wait(self, then: Callable[[], None] | None) -> None:
        if self.waiting is not None:
            self.waiting.cancel()
        self.waiting = None if then is None else self.loop.call_later(_PATIENCE, then)

    def _close_idle(self) -> None:
        if self.cycle is None or self.cycle.response_complete:
            self.transport.abort()
