"""A dashboard on a free port with a daemon that only shows, and a page that talks to it."""

import json
import time
import urllib.error
import urllib.request
from typing import Any

from websockets.sync.client import ClientConnection, connect

from navigation.dashboard import Dashboard
from navigation.dashboard.settings.desk import Desk
from tests.support.runs.packed import unpack
from tests.support.runs.shown import FakeDaemon
from tests.support.waiting import wait_until

TOKEN = "a-token-of-some-length"
VIEWER = "a-token-for-looking"
KEY = "0123456789abcdef"


class Site:
    """A dashboard of a daemon that only shows."""

    def __init__(self, daemon: FakeDaemon, desk: Desk | None = None) -> None:
        self.daemon = daemon
        self.said: list[str] = []
        self.dashboard = Dashboard(daemon, say=self.said.append, desk=desk)

    def __enter__(self) -> "Site":
        self.dashboard.__enter__()
        assert wait_until(lambda: self.dashboard.hub is not None), self.said
        return self

    def __exit__(self, *_exc: object) -> None:
        self.dashboard.__exit__()

    @property
    def address(self) -> str:
        assert self.dashboard.url is not None
        return self.dashboard.url.split("//")[1].split("/")[0]

    def get(
        self, path: str, method: str = "GET", body: bytes | None = None, **headers: str
    ) -> tuple[int, str, dict[str, str]]:
        names = {name.replace("_", "-"): value for name, value in headers.items()}
        url = f"http://{self.address}{path}"
        request = urllib.request.Request(url, body, names, method=method)
        try:
            with urllib.request.urlopen(request, timeout=10) as answer:
                return (
                    answer.status,
                    answer.read().decode(),
                    {k.lower(): v for k, v in answer.headers.items()},
                )
        except urllib.error.HTTPError as error:
            with error:
                return error.code, error.read().decode(), {}

    def live(self, *protocols: str, origin: str | None = None, **options: Any) -> "Page":
        asked: Any = ["clearway.1", *protocols]
        return Page(
            connect(f"ws://{self.address}/live", subprotocols=asked, origin=origin, **options)  # type: ignore[arg-type]
        )

    def refused(self, kind: str) -> int:
        assert self.dashboard.hub is not None
        return self.dashboard.hub.gate.refused[kind]


class Page:
    """A page that reads everything, and answers nothing by itself."""

    def __init__(self, line: ClientConnection) -> None:
        self.line = line.__enter__()

    def __enter__(self) -> "Page":
        return self

    def __exit__(self, *_exc: object) -> None:
        self.line.close()

    def send(self, **message: object) -> None:
        self.line.send(json.dumps(message))

    def hear(self, kind: str, seconds: float = 60.0) -> dict[str, Any]:
        """The next message of a kind; the arrays of packed ones are under ``arrays``.

        A page that is heard has it at once; ``seconds`` ends a test that fails.
        """
        end_s = time.monotonic() + seconds
        while (left_s := end_s - time.monotonic()) > 0.0:
            data = self.line.recv(left_s)
            if isinstance(data, bytes):
                head, arrays = unpack(data)
                message = {**head, "arrays": arrays}
            else:
                message = json.loads(data)
            if message["type"] == kind:
                return message
        raise AssertionError(f"no {kind} within {seconds} s")

    def join(self, key: str = KEY, name: str = "") -> dict[str, Any]:
        self.send(type="join", key=key, name=name)
        return self.hear("joined")

    def take(self) -> bool:
        """Take control, and return whether the page has it."""
        self.send(type="take", id=1)
        return bool(self.hear("answer")["ok"])

    def order(self, order: str, **fields: object) -> dict[str, Any]:
        self.send(type="order", id=1, order=order, **fields)
        return self.hear("answer")
