"""Earlier runs over HTTP: `/api/runs` in pages, `/api/runs/RUN/FILE` in pieces.

Rules
- Anyone who may look at the page may look at these.
- One listing is made at a time, and serves equal requests within `FRESH_S`.
- An answer has at most `PIECE_BYTES` of a file (``Range: bytes=FIRST-LAST``), so that a slow line
  keeps little in memory.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any, BinaryIO, Final

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response

from navigation.config.secrecy.secrets import hide_in
from navigation.config.values import MOST_ROBOTS
from navigation.dashboard.admission.access import AccessGate, Refusal, bearer_of, refused
from navigation.dashboard.kept.runs import KeptFile, KeptRun, KeptRuns, is_run
from navigation.shared.outside import finite_number

PIECE_BYTES: Final = 524_288
MOST_A_PAGE: Final = 50
FRESH_S: Final = 1.0
TYPES: Final = {
    "json": "application/json",
    "jsonl": "text/plain; charset=utf-8",
    "svg": "image/svg+xml",
    "mcap": "application/octet-stream",
}
_RANGE: Final = re.compile(r"bytes=(\d{1,15})-(\d{0,15})", re.ASCII)


class KeptAnswers:
    """Answers for one page; ``workers`` may wait for the disk."""

    def __init__(
        self, runs: KeptRuns, gate: AccessGate, workers: Executor, clock: Callable[[], float]
    ) -> None:
        self._runs, self._gate, self._workers, self._clock = runs, gate, workers, clock
        self._listing = asyncio.Lock()
        self._newest: tuple[tuple[str | None, int], float, dict[str, Any]] | None = None

    async def list_runs(self, request: Request) -> Response:
        """``?count=N&before=RUN``: runs, newest first."""
        refusal = self._refusal(request)
        if refusal is not None:
            return refusal
        before = request.query_params.get("before")
        if before is not None and not is_run(before):
            return _plain(400, "before: must be the name of a run")
        count = request.query_params.get("count", str(MOST_A_PAGE))
        if not re.fullmatch(r"\d{1,3}", count, re.ASCII) or not 1 <= int(count) <= MOST_A_PAGE:
            return _plain(400, f"count: must be 1 to {MOST_A_PAGE}")
        return JSONResponse(await self._page(before, int(count)))

    async def _page(self, before: str | None, count: int) -> dict[str, Any]:
        async with self._listing:
            now_s = self._clock()
            if self._newest is not None:
                asked, made_s, made = self._newest
                if asked == (before, count) and now_s - made_s < FRESH_S:
                    return made
            work = asyncio.get_running_loop().run_in_executor
            page = await work(self._workers, self._runs.page, before, count)
            runs = [_run_body(run) for run in page.runs]
            told = {"runs": runs, "total": page.total, "following": page.following}
            body: dict[str, Any] = hide_in(told)
            self._newest = ((before, count), now_s, body)
            return body

    async def file(self, request: Request) -> Response:
        """A file of a run, or a piece of it."""
        refusal = self._refusal(request)
        if refusal is not None:
            return refusal
        run, name = request.path_params["run"], request.path_params["file"]
        work = asyncio.get_running_loop().run_in_executor
        try:
            return await work(self._workers, self._piece, run, name, request.headers)
        except FileNotFoundError:
            return _plain(404, "there is no such file of a run")
        except OSError as error:
            return _plain(404, f"the file cannot be read: {error.strerror or error}")

    def _piece(self, run: str, name: str, headers: Any) -> Response:
        with self._runs.opened(run, name) as file:
            return _piece_of(file, name, headers.get("range"))

    def _refusal(self, request: Request) -> Response | None:
        role = self._gate.role(bearer_of(request.headers.get("authorization")))
        return refused(role) if isinstance(role, Refusal) else None


def _piece_of(file: BinaryIO, name: str, wanted: str | None) -> Response:
    size = file.seek(0, 2)
    kind = TYPES[name.rsplit(".", 1)[-1]]
    headers = {
        "accept-ranges": "bytes",
        "cache-control": "no-store",
        "content-disposition": f'attachment; filename="{name}"',
    }
    match = _RANGE.fullmatch(wanted or "")
    if match is None and size > PIECE_BYTES:
        limit = f"at most {PIECE_BYTES} bytes at once, by 'Range: bytes=FIRST-LAST'"
        return _plain(413, f"the file has {size} bytes: ask for {limit}")
    first = 0 if match is None else int(match[1])
    last = size - 1 if match is None or not match[2] else min(int(match[2]), size - 1)
    last = min(last, first + PIECE_BYTES - 1)
    if match is not None and first > last:
        return _plain(416, "the range is not in the file", **{"content-range": f"bytes */{size}"})
    file.seek(first)
    body = file.read(last - first + 1)
    if match is not None:
        headers["content-range"] = f"bytes {first}-{first + len(body) - 1}/{size}"
    return Response(body, 200 if match is None else 206, headers, kind)


def _run_body(run: KeptRun) -> dict[str, Any]:
    report = run.report or {}
    robots = report.get("robots")
    return {
        "name": run.name,
        "began": run.began.isoformat(),
        "running": run.is_running,
        "state": _text(report.get("state")),
        "reason": _text(report.get("reason")),
        "duration_s": finite_number(report.get("duration_s")),
        "robots": list(robots)[:MOST_ROBOTS] if isinstance(robots, dict) else [],
        "files": [_file_body(file) for file in run.files],
        "recordings": [_file_body(file) for file in run.recordings],
    }


def _file_body(file: KeptFile) -> dict[str, Any]:
    return {"name": file.name, "bytes": file.size_bytes}


def _text(value: object) -> str | None:
    return value[:400] if isinstance(value, str) else None


def _plain(status: int, sentence: str, **headers: str) -> Response:
    return PlainTextResponse(sentence + "\n", status, headers=headers)
