"""The dashboard's addresses: the page, its websocket, /api, /metrics and /healthz.

Everything passes the gate first: Host and Origin at once, a token where one is needed. The page's
own files hold no secrets and need no token: a browser cannot send one for them.
"""

from __future__ import annotations

from importlib.resources import files
from typing import Final

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from navigation.dashboard.admission.access import (
    PROTOCOL,
    AccessGate,
    Refusal,
    bearer_of,
    refused,
    token_of,
)
from navigation.dashboard.calibrating.bench import Bench
from navigation.dashboard.calibrating.routes import calibration_routes
from navigation.dashboard.hub import LOOP_DEAD_S, MOST_VIEWERS, Hub
from navigation.dashboard.kept.answers import KeptAnswers
from navigation.dashboard.kept.runs import KeptRuns
from navigation.dashboard.messages.palette import stylesheet
from navigation.dashboard.metrics import metrics_text
from navigation.dashboard.orders import buttons
from navigation.dashboard.settings.desk import Desk
from navigation.dashboard.settings.routes import settings_routes
from navigation.dashboard.viewer import Viewer

MOST_BODY_BYTES: Final = 4096
HTML: Final = "text/html; charset=utf-8"
TYPES: Final = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".webmanifest": "application/manifest+json",
}
HEADERS: Final = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        "connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cache-control": "no-cache",
    "cross-origin-resource-policy": "same-origin",
}


def make_app(
    hub: Hub, runs: KeptRuns, desk: Desk | None = None, bench: Bench | None = None
) -> ASGIApp:
    """The whole application around a hub, with the earlier runs.

    Without a desk there are no settings, without a bench no calibration.
    """
    pages = _Pages(hub)
    kept = KeptAnswers(runs, hub.gate, hub.workers, hub.clock)
    routes = [
        *file_routes("index.html"),
        Route("/api/state", pages.state),
        Route("/api/stop", pages.stop, methods=["POST"]),
        Route("/api/runs", kept.list_runs),
        Route("/api/runs/{run}/{file}", kept.file),
        Route("/metrics", pages.metrics),
        Route("/healthz", pages.health),
        *settings_routes(hub, desk),
        *calibration_routes(hub, bench),
        WebSocketRoute("/live", pages.live),
    ]
    return Gatekeeper(Starlette(routes=routes), hub.gate)


class Gatekeeper:
    """Checks Host and Origin first, and adds the headers of every answer."""

    def __init__(self, app: ASGIApp, gate: AccessGate) -> None:
        self._app, self._gate = app, gate

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        refusal = self._gate.admit(headers.get(b"host"), headers.get(b"origin"))
        if refusal is not None and scope["type"] == "websocket":
            await _deny(WebSocket(scope, receive, send), refusal)
        elif refusal is not None:
            await refused(refusal)(scope, receive, send)
        else:
            await self._app(scope, receive, _with_headers(send))


def _with_headers(send: Send) -> Send:
    extra = [(name.encode(), value.encode()) for name, value in HEADERS.items()]

    async def wrapped(message: Message) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", []), *extra]
        await send(message)

    return wrapped


class _Pages:
    def __init__(self, hub: Hub) -> None:
        self._hub = hub

    async def state(self, request: Request) -> Response:
        role = self._hub.gate.role(bearer_of(request.headers.get("authorization")))
        if isinstance(role, Refusal):
            return refused(role)
        state = self._hub.state_now()
        return JSONResponse(state or {"type": "state", "mission": None})

    async def stop(self, request: Request) -> Response:
        """Stop without a websocket: the page's fallback when its own is lost."""
        refusal = self._hub.gate.may_stop(bearer_of(request.headers.get("authorization")))
        if refusal is not None:
            return refused(refusal)
        size = 0
        async for part in request.stream():
            size += len(part)
            if size > MOST_BODY_BYTES:
                self._hub.gate.count("oversized")
                return refused(Refusal(413, "oversized", "the request is too long"))
        client = request.client.host if request.client else "somebody"
        result = self._hub.give({"order": "stop"}, client)
        self._hub.note("stop", f"{client}: STOP")
        return JSONResponse({k: result[k] for k in ("ok", "error") if k in result})

    async def metrics(self, request: Request) -> Response:
        role = self._hub.gate.role(bearer_of(request.headers.get("authorization")))
        if isinstance(role, Refusal):
            return refused(role)
        return Response(metrics_text(self._hub), media_type="text/plain; version=0.0.4")

    async def health(self, _request: Request) -> Response:
        """200 while the control loop runs, 503 when it hangs; other troubles in words."""
        alive = self._hub.loop_age_s < LOOP_DEAD_S
        state = self._hub.state_now()
        body: dict[str, object] = {"status": "ok" if alive else "the control loop does not answer"}
        if state is not None:
            camera, link = state["camera"], state["link"]
            body |= {
                "mission": state["mission"]["state"],
                "camera": camera["reason"] or camera["state"],
                "link": link["reason"] or link["state"],
            }
        return JSONResponse(body, status_code=200 if alive else 503)

    async def live(self, socket: WebSocket) -> None:
        hub = self._hub
        offered = socket.scope.get("subprotocols", [])
        role = hub.gate.role(token_of(offered))
        if isinstance(role, Refusal):
            await _deny(socket, role)
            return
        if PROTOCOL not in offered:
            hub.gate.count("protocol")
            sentence = f"the subprotocol must be {PROTOCOL}: load the page again"
            await _deny(socket, Refusal(400, "protocol", sentence))
            return
        place = hub.admit(role)
        if place is None:
            hub.gate.count("viewers")
            await _deny(socket, Refusal(503, "viewers", f"{MOST_VIEWERS} viewers are here already"))
            return
        await Viewer(hub, socket, place).serve()


async def _deny(socket: WebSocket, refusal: Refusal) -> None:
    await socket.send_denial_response(refused(refusal))


def file_routes(page: str) -> list[Route]:
    """Addresses of a page, which is at /, and its files, read once: nothing else is served."""
    folder = files("navigation.dashboard") / "static"
    found = {
        f"/{item.name}": (item.read_bytes(), TYPES["." + item.name.rsplit(".", 1)[-1]])
        for item in folder.iterdir()
        if "." + item.name.rsplit(".", 1)[-1] in TYPES
    }
    text = (folder / page).read_bytes().replace(b"<!-- orders -->", buttons().encode())
    text = text.replace(b"<!-- calibration -->", (folder / "calibration.html").read_bytes())
    found["/"] = found[f"/{page}"] = text, HTML
    found["/palette.css"] = (stylesheet().encode(), TYPES[".css"])

    async def show(request: Request) -> Response:
        body, kind = found[request.url.path]
        return Response(body, media_type=kind)

    return [Route(address, show) for address in found]
