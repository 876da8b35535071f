"""The workbench's server: one study, on the loopback address, behind a token; thin routes over its desks."""

import asyncio
import errno
import secrets
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route

from vasowave.base.errors import InputError, VasowaveError
from vasowave.base.io.files import in_words, is_full
from vasowave.base.runtime.writing import Part, opened
from vasowave.base.stores import parsed
from vasowave.lung.places import VoxelSize, parse_voxel
from vasowave.workbench.access import REPORT_POLICY, App, Guarded, Patient, TooLargeError, TooSlowError
from vasowave.workbench.actions import act
from vasowave.workbench.arrivals import Arrivals
from vasowave.workbench.cohorts import Cohorts
from vasowave.workbench.cures import buttons
from vasowave.workbench.desk import Desk
from vasowave.workbench.explorer import Explorer
from vasowave.workbench.figures import CHOICES, KINDS, Wish, figure_file, line_of
from vasowave.workbench.lungs import Lungs, Wishes
from vasowave.workbench.opening import place_of, sorted_in
from vasowave.workbench.recordings import Recordings
from vasowave.workbench.running import Runs
from vasowave.workbench.studies import checked, outdated, shown, state
from vasowave.workbench.workplace import Workplace

_PAGE = Path(__file__).parent / "page"
_TEMPLATES = Path(__file__).parents[1] / "study" / "report" / "templates"
_OF_REPORT = ("style.css", "turntable.js")
"""What the pages of the report and the workbench share: colors, and things in space."""

_TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_THREADS = 4  # of one route: what takes long there keeps no other waiting
_FORBIDDEN_ERRORS = (errno.EACCES, errno.EPERM, errno.EROFS)
_LAST_WORD = 1  # s that answers under way have when the workbench ends


class Workbench:
    """One study that is open, and the application that answers for it.

    Holds state because desks, runs and what was read last outlive a request.
    """

    def __init__(self, folder: Path, image: Path | None = None) -> None:
        self.at: Workplace = Workplace.around(Desk(folder), image)
        self.desk: Desk = self.at.desk
        self.recordings: Recordings = self.at.recordings
        self.runs: Runs = self.at.runs
        self.lungs: Lungs = self.at.lungs
        self.arrivals: Arrivals = self.at.arrivals
        self.explorer: Explorer = Explorer()
        self.cohorts: Cohorts = Cohorts()

    def app(self) -> App:
        """Return the application, without its guard."""
        desk, answered = self.desk, self._answered
        routes = [
            Route("/", self._page),
            Route("/page/{name}", self._page),
            Route("/state", answered(lambda ask: state(desk, self.runs, self.arrivals))),
            Route("/study", answered(lambda ask: shown(desk))),
            Route("/check", answered(lambda ask: checked(desk))),
            Route("/recording", answered(lambda ask: self.recordings.described(desk, ask("animal")))),
            Route("/trace", answered(self._trace)),
            Route("/outdated", answered(lambda ask: outdated(desk))),
            Route("/results", answered(lambda ask: self.cohorts.animals(desk) | {"figure": CHOICES})),
            Route("/means", answered(lambda ask: self.cohorts.means(desk, ask("quantity")))),
            Route("/model", answered(lambda ask: self.explorer.described(desk, ask("animal"), ask("law")))),
            Route("/band", answered(lambda ask: self.explorer.band(desk, ask("animal"), ask("law")))),
            Route("/lung", answered(lambda ask: self.lungs.described(desk, ask("image")))),
            Route("/volume", answered(lambda ask: _bytes(self.lungs.reduced(desk, ask("image"), _size(ask("voxel")))))),
            Route("/vessels", self._posted(self._vessels), methods=["POST"]),
            Route("/act", self._posted(lambda message: {"said": act(self.at, message)}), methods=["POST"]),
            Route("/simulate", self._posted(self._of_values(self.explorer.simulated)), methods=["POST"]),
            Route("/predict", self._posted(self._of_values(self.explorer.predicted)), methods=["POST"]),
            Route("/figure", self._posted(self._figure), methods=["POST"]),
            Route("/upload", self._upload, methods=["PUT"]),
            Route("/report/{name:path}", self._report),
        ]
        return Starlette(routes=routes, exception_handlers={
            VasowaveError: _refused, TooLargeError: _cut_off, TooSlowError: _cut_off, OSError: _unforeseen,
            Exception: _unforeseen,
        })  # fmt: skip

    def _answered(self, answer: Callable[[Callable[[str], str]], Any]) -> Any:
        """Return what answers a question in a thread of its own, so that no other waits for it."""
        threads = asyncio.Semaphore(_THREADS)

        async def endpoint(request: Request) -> Response:
            async with threads:
                result = await run_in_threadpool(answer, lambda name: request.query_params.get(name, ""))
            return result if isinstance(result, Response) else JSONResponse(result)

        return endpoint

    def _posted(self, answer: Callable[[Any], Any]) -> Any:
        threads = asyncio.Semaphore(_THREADS)

        async def endpoint(request: Request) -> Response:
            body = await request.body()
            async with threads:
                result = await run_in_threadpool(lambda: answer(_message(body)))
            return result if isinstance(result, Response) else JSONResponse(result)

        return endpoint

    def _trace(self, ask: Callable[[str], str]) -> Response:
        try:
            start, end, width = float(ask("start")), float(ask("end")), int(ask("width"))
        except ValueError:
            raise InputError("a part of a signal has a start, an end, and a width in pixels") from None
        values = self.recordings.trace(self.desk, ask("animal"), ask("signal"), start, end, width)
        return _bytes(values.astype("<f4").tobytes())

    def _of_values(self, answer: Callable[[Desk, str, str, dict[str, float]], Any]) -> Callable[[Any], Any]:
        """Return what answers a message of an animal, a law and values of parameters."""

        def answered(message: Any) -> Any:
            values = message.get("values", {})
            if not isinstance(values, dict) or not all(map(_is_number, values.values())):
                raise InputError("values are finite numbers by the names of parameters")
            animal, law = (str(message.get(key, "")) for key in ("animal", "law"))
            return answer(self.desk, animal, law, {name: float(value) for name, value in values.items()})

        return answered

    def _vessels(self, message: Any) -> Any:
        if not isinstance(message.get("wishes"), dict):
            raise InputError("vessels are looked for with settings")
        return self.lungs.shown(self.desk, str(message.get("image", "")), Wishes(**message["wishes"]))

    def _figure(self, message: Any) -> Any:
        wish = Wish(**{name: value for name, value in message.items() if name != "only"})
        if message.get("only") == "line":
            return {"line": line_of(self.desk, wish)}
        return Response(figure_file(self.desk, wish), media_type=KINDS[wish.format])

    async def _upload(self, request: Request) -> Response:
        """Put a file into the study, whole or not at all; never over another."""
        name = request.query_params.get("name", "")
        place = await run_in_threadpool(place_of, self.desk, name)
        with in_words(place), Part(place) as upload:
            async for chunk in request.stream():
                upload.write(chunk)
            upload.end()
            name = await run_in_threadpool(sorted_in, self.desk, upload.path, place)
            self.arrivals.expect(self.desk.folder / name)
            return JSONResponse({"name": name})

    async def _page(self, request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        files = {file.name: file for file in (*_PAGE.iterdir(), *(_TEMPLATES / file for file in _OF_REPORT))}
        if name not in files or files[name].suffix not in _TYPES:
            return Response(status_code=404)
        return Response(files[name].read_bytes(), media_type=_TYPES[files[name].suffix])

    async def _report(self, request: Request) -> Response:
        try:
            path = self.desk.inside(f"report/{request.path_params['name']}")
            is_report = path.resolve().is_relative_to((self.desk.folder / "report").resolve())
            with opened(path):  # a file without a second name, which could be any file of the disk
                pass
        except (InputError, OSError):
            is_report = False
        if not is_report:
            return Response("There is no such report.", status_code=404)
        return FileResponse(path, headers={"content-security-policy": REPORT_POLICY})


Opened = Callable[[str, Guarded], None]
"""Called with the address once it can be opened, and with who guards it and gives out tickets."""


def serve(folder: Path, port: int, opened: Opened, image: Path | None = None) -> bool:
    """Serve a study until it is interrupted; return whether a run that was begun here goes on.

    Parameters
    ----------
    folder : Path
    port : int
        0 for any that is free.
    opened : callable
    image : Path, optional
        An image that lies elsewhere and is to be looked at.

    Raises
    ------
    InputError
        The port is taken.
    """
    workbench = Workbench(folder, image)
    with _door(port) as door, suppress(KeyboardInterrupt):
        server_of(workbench, door, opened).run(sockets=[door])
    return workbench.runs.close()


def server_of(workbench: Workbench, door: socket.socket, opened: Opened) -> uvicorn.Server:
    """Return the server of a workbench behind a key of its own, for a socket that is bound."""
    port, token = door.getsockname()[1], secrets.token_urlsafe(24)
    guard = Guarded(workbench.app(), token, port)
    config = uvicorn.Config(
        guard, http=Patient, ws="none", loop="asyncio", lifespan="off",
        log_config=None, log_level="critical", access_log=False, server_header=False,
        timeout_graceful_shutdown=_LAST_WORD,
    )  # fmt: skip
    return _Server(config, lambda: opened(f"http://127.0.0.1:{port}/{token}/", guard))


@contextmanager
def _door(port: int) -> Iterator[socket.socket]:
    with socket.socket() as door:
        door.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            door.bind(("127.0.0.1", port))
        except OSError as error:
            raise InputError(f"port {port}: {(error.strerror or str(error)).lower()}; give another, or none") from None
        yield door


class _Server(uvicorn.Server):
    """Tells when it answers."""

    def __init__(self, config: uvicorn.Config, opened: Callable[[], None]) -> None:
        super().__init__(config)
        self.opened = opened

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen, and tell."""
        await super().startup(sockets)
        self.opened()


def _message(body: bytes) -> Any:
    try:
        message = parsed(body)
    except ValueError:
        message = None
    if not isinstance(message, dict):
        raise InputError("this is not a message of the workbench")
    return message


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) <= sys.float_info.max


def _size(text: str) -> VoxelSize | None:
    return parse_voxel(text) if text else None


def _bytes(content: bytes) -> Response:
    return Response(content, media_type="application/octet-stream")


async def _refused(request: Request, error: Exception) -> Response:
    cures = error.cures if isinstance(error, VasowaveError) else ()
    return JSONResponse({"error": str(error), "remedies": buttons(cures)}, status_code=400)


async def _cut_off(request: Request, error: Exception) -> Response:
    large = isinstance(error, TooLargeError)
    text = "this is too large" if large else "too little of this came for a while; send it again"
    return JSONResponse({"error": text}, status_code=413 if large else 408, headers={"connection": "close"})


async def _unforeseen(request: Request, error: Exception) -> Response:
    """Say what went wrong; the server lives on."""
    if is_full(error):
        return JSONResponse({"error": "no space left on the disk; make room and do it again"}, status_code=507)
    if isinstance(error, OSError) and error.errno in _FORBIDDEN_ERRORS:
        text = f"{error.filename}: {(error.strerror or '').lower()}; see who may read and write there, then do it again"
        return JSONResponse({"error": text}, status_code=403)
    text = f"the workbench failed here ({type(error).__name__}: {error}); reload the page to see what is stored"
    return JSONResponse({"error": text}, status_code=500)
