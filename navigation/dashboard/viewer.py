"""One viewer: a websocket with a task that sends news and one that receives messages.

Rules
- Only answers and notices are queued: a slow viewer gets the newest of everything, less often.
- Malformed or oversized messages are refused and counted; a viewer that repeats them, or sends more
  messages than a page has reason to, is cut off.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections import defaultdict, deque
from collections.abc import Coroutine, Mapping
from typing import Any, Final

from starlette.websockets import WebSocket, WebSocketDisconnect

from navigation.dashboard.admission.access import PROTOCOL, TOKEN_TO_STOP, Role
from navigation.dashboard.admission.allowance import Allowance
from navigation.dashboard.admission.seat import public_half
from navigation.dashboard.attention import Attention
from navigation.dashboard.hub import Hub
from navigation.dashboard.messages.chronicle import LOG_LINES
from navigation.dashboard.messages.picture import width_for
from navigation.dashboard.messages.rings import Ring
from navigation.dashboard.orders import ZONE_ORDERS, order_told, refusal_of
from navigation.orders.arguments import read_stations
from navigation.orders.errors import ControlError
from navigation.shared.outside import (
    OutsideError,
    in_short,
    read_object,
)
from navigation.shared.supervisor import in_words

MOST_CHARACTERS: Final = 65_536
PATIENCE: Final = 20
"""Malformed messages at which a connection is closed."""
ANSWERS: Final = 64
MESSAGES_S: Final = 60.0
"""Messages a second beside one for each picture, for `BURST_S` at once."""
BURST_S: Final = 5.0
NAME_CHARACTERS: Final = 40
NAMELESS: Final = "somebody"
POLICY, TOO_BIG, GOING_AWAY, TRY_LATER = 1008, 1009, 1001, 1013


class MalformedError(ValueError):
    """Error: a message outside the protocol."""


class Viewer:
    """The other end of an admitted websocket."""

    def __init__(self, hub: Hub, socket: WebSocket, attention: Attention) -> None:
        self.hub, self.attention = hub, attention
        self.role, self.number = attention.role, attention.number
        self.name = NAMELESS
        self._socket = socket
        self._answers: deque[dict[str, Any]] = deque(maxlen=ANSWERS)
        self._sent: defaultdict[str, int] = defaultdict(int)
        self._next: defaultdict[tuple[str, str | None], int] = defaultdict(int)
        self._epoch = hub.epoch
        self._bad = 0
        self._allowance = Allowance(MESSAGES_S + hub.section.picture_rate_hz, BURST_S, hub.clock())
        self._left = False
        self._preview: asyncio.Task[None] | None = None
        self._saving: set[asyncio.Task[None]] = set()

    async def serve(self) -> None:
        """Serve until the visitor leaves, misbehaves, or the dashboard closes."""
        tasks: list[asyncio.Task[Any]] = []
        try:
            await self._socket.accept(subprotocol=PROTOCOL)
            reasons = (self.hub.closing.wait(), self.attention.displaced.wait())
            tasks += [asyncio.ensure_future(one) for one in (self._send(), self._take(), *reasons)]
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (*tasks, *([self._preview] if self._preview else [])):
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self.hub.viewers.discard(self.attention)
            if not any(other.key == self.attention.key for other in self.hub.viewers):
                self.hub.seat.go(self.attention.key, self.hub.clock(), left=self._left)
        if self.hub.closing.is_set():
            await self._close(GOING_AWAY, "the program ends")
        elif self.attention.displaced.is_set():
            await self._close(TRY_LATER, "all places are taken, and a viewer with a token came")

    # Out.

    async def _greet(self) -> None:
        self._epoch = self.hub.epoch
        self._sent.clear()
        self._next.clear()
        role = "nobody" if self.hub.refusal else self.role.value
        await self._send_json({**self.hub.hello, "number": self.number, "role": role})

    async def _send(self) -> None:
        await self._greet()
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            while True:
                await self.attention.news.wait()
                self.attention.news.clear()
                await self._send_news()

    async def _send_news(self) -> None:
        hub = self.hub
        if self._epoch != hub.epoch:
            await self._greet()
        while self._answers:
            await self._send_json(self._answers.popleft())
        while self.attention.notices:
            await self._send_json({"type": "notice", "text": self.attention.notices.popleft()})
        if self._is_new("state", hub.state_number):
            await self._socket.send_text(hub.state_text)
        if self._is_new("plan", hub.plan_number):
            await self._socket.send_bytes(hub.plan)
        if self._is_new("world", hub.world.number):
            await self._socket.send_bytes(hub.world.message)
        if self._is_new("zones", hub.zones.number):
            await self._socket.send_bytes(hub.zones.message)
        if self._is_new("places", hub.saved_number):
            await self._send_json({"type": "places", **hub.saved.body()})
        await self._send_ring("log", hub.chronicle.log, LOG_LINES)
        for robot, chronicle in hub.chronicles.rings():
            await self._send_ring("track", chronicle.track, 2000, robot)
            await self._send_ring("samples", chronicle.samples, 240, robot)
        now_s = hub.clock()
        attention = self.attention
        could = attention.wants_picture(now_s, hub.picture_pause_s())
        if attention.wants_heat and self._is_new("heat", hub.heat.number):
            await self._socket.send_bytes(hub.heat.message)
        picture, number = hub.pictures.get(attention.sees, (b"", 0))
        if could and number and self._is_new("picture", number):
            attention.shown(now_s)
            hub.pictures_sent += 1
            await self._socket.send_bytes(picture)

    def _is_new(self, what: str, number: int) -> bool:
        if number == self._sent[what]:
            return False
        self._sent[what] = number
        return True

    async def _send_ring(
        self, name: str, ring: Ring[Any], most: int, robot: str | None = None
    ) -> None:
        if ring.next == self._next[name, robot]:
            return
        first, items = ring.since(self._next[name, robot], most)
        self._next[name, robot] = first + len(items)
        if name == "log":
            items = [[line.wall_s, line.level, line.text] for line in items]
        whose = {} if robot is None else {"robot": robot}
        await self._send_json({"type": name, "first": first, "items": items, **whose})
        if self._next[name, robot] < ring.next:
            self.attention.news.set()

    async def _send_json(self, message: dict[str, Any]) -> None:
        await self._socket.send_text(json.dumps(message, allow_nan=False))

    def _answer(self, message: dict[str, Any]) -> None:
        self._answers.append(message)
        self.attention.news.set()

    async def _close(self, code: int, reason: str) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._socket.close(code, reason)

    # In.

    async def _take(self) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                if event.get("code") == TOO_BIG:
                    self.hub.gate.count("oversized")
                self._left = event.get("code") == GOING_AWAY
                return
            text = event.get("text")
            if text is not None and len(text) > MOST_CHARACTERS:
                self.hub.gate.count("oversized")
                await self._close(TOO_BIG, f"a message may have {MOST_CHARACTERS} characters")
                return
            if not self._allowance.take(self.hub.clock()):
                self.hub.gate.count("flood")
                await self._close(POLICY, "too many messages")
                return
            try:
                self._handle(_read(text))
            except (MalformedError, OutsideError, ControlError) as error:
                self.hub.gate.count("malformed")
                self._bad += 1
                if self._bad >= PATIENCE:
                    await self._close(POLICY, "too many malformed messages")
                    return
                self._answer({"type": "error", "error": str(error)})

    def _handle(self, message: dict[str, Any]) -> None:
        match message.get("type"):
            case "join":
                self._join(message)
            case "ack":
                self.attention.drawn()
            case "watch":
                self._watch(message)
            case "take":
                self._sit(message)
            case "release":
                if self.hub.seat.release(self.attention.key):
                    self.hub.tell_now()
                    self.hub.note("info", f"{self.name} left the arena free")
            case "order":
                self._order(message)
            case "preview":
                self._ask_preview(message)
            case "replay":
                error = self.hub.steer(message)
                self._reply(message, _outcome(error))
            case "place":
                self._ask_place(message)
            case "ping":
                self._answer({"type": "pong", "id": _number_of(message)})
            case other:
                raise MalformedError(f"type {in_short(other)}: is none of the protocol's")

    def _watch(self, message: dict[str, Any]) -> None:
        """Note the pictures that the page shows; ``width_px`` is in the screen's pixels."""
        most_px = self.hub.section.picture_width_px
        shown_px = message.get("width_px", most_px)
        if not isinstance(shown_px, int) or isinstance(shown_px, bool) or shown_px < 1:
            raise MalformedError(f"width_px: must be a whole number >= 1, not {in_short(shown_px)}")
        self.attention.is_watching = message.get("on") is True
        self.attention.kind = "camera" if message.get("camera") is True else "picture"
        self.attention.width_px = width_for(shown_px, most_px)
        self.attention.wants_heat = message.get("heat") is True

    def _join(self, message: dict[str, Any]) -> None:
        key, name = message.get("key"), message.get("name", "")
        if not isinstance(key, str) or not 16 <= len(key) <= 128 or not key.isascii():
            raise MalformedError("key: must be 16 to 128 characters of ASCII")
        if not isinstance(name, str) or len(name) > NAME_CHARACTERS or not name.isprintable():
            raise MalformedError(f"name: must be at most {NAME_CHARACTERS} printable characters")
        self.attention.key = key
        self.name = name.strip() or NAMELESS
        self.hub.seat.come(key, self.name)
        self._answer({"type": "joined", "seat": public_half(key), "name": name.strip()})

    def _sit(self, message: dict[str, Any]) -> None:
        if self.hub.refusal is not None:
            error: str | None = self.hub.refusal
        elif self.role is Role.VISITOR:
            error = TOKEN_TO_STOP
        elif not self.role.may_drive:
            error = "this token is for looking and stopping only"
        elif not self.attention.key:
            raise MalformedError("take: join first")
        else:
            error = self._take_control()
        self._reply(message, _outcome(error))

    def _take_control(self) -> str | None:
        """Take control, and inform both pages if another one loses it; return why not."""
        hub, key, before = self.hub, self.attention.key, self.hub.seat.holder
        is_supervisor = self.role is Role.SUPERVISOR
        error = hub.seat.take(key, self.name, hub.clock(), from_anyone=is_supervisor)
        if error is None and (before is None or before.key != key):
            sentence = f"{self.name} is in control"
            if before is not None:
                who = "the supervisor" + (f" {self.name}" if self.name != NAMELESS else "")
                sentence = f"{who} has taken control from {before.name}"
                hub.tell_pages((before.key, key), sentence)
            hub.tell_now()
            hub.note("info", sentence)
        return error

    def _order(self, message: dict[str, Any]) -> None:
        refusal = self._refusal_of(message)
        if refusal is not None:
            self.hub.gate.count("order")
            self._reply(message, _outcome(refusal))
        elif message["order"] in ZONE_ORDERS:
            self._start(self._change_zones(message))
        else:
            self._was_given(message, self.hub.give(message, self.name))

    def _refusal_of(self, message: dict[str, Any]) -> str | None:
        return self.hub.refusal or refusal_of(
            message.get("order"),
            may_stop=self.role is not Role.VISITOR,
            may_drive=self.role.may_drive,
            holds=bool(self.attention.key) and self.hub.seat.is_held_by(self.attention.key),
        )

    async def _change_zones(self, message: dict[str, Any]) -> None:
        def change() -> dict[str, Any]:
            refusal = self._refusal_of(message)  # others may have control by now
            return _outcome(refusal) if refusal else self.hub.give(message, self.name)

        self._was_given(message, await self.hub.change_zones(change))

    def _was_given(self, message: dict[str, Any], result: Mapping[str, Any]) -> None:
        self.hub.seat.touch(self.attention.key, self.hub.clock())
        level = "stop" if message["order"] == "stop" else "order"
        outcome = "" if result["ok"] else f" - refused: {result['error']}"
        self.hub.note(level, f"{self.name}: {order_told(message)}{outcome}")
        self._reply(message, {k: result[k] for k in ("ok", "error", "trouble") if k in result})

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.ensure_future(work)
        self._saving.add(task)
        task.add_done_callback(self._saving.discard)

    def _ask_place(self, message: dict[str, Any]) -> None:
        hub = self.hub
        if hub.refusal is not None or not self.role.may_drive:
            error = hub.refusal or "this page has no token that may save places"
            self._reply(message, {"ok": False, "error": error})
            return

        async def work() -> None:
            error = await hub.change_places(message)
            if error is None:
                what = str(message["do"]).removesuffix("e") + "ed"
                hub.note("info", f"{self.name} {what} the place {message['name'].strip()!r}")
            self._reply(message, _outcome(error))

        self._start(work())

    def _ask_preview(self, message: dict[str, Any]) -> None:
        stations = read_stations(message.get("stations"))
        if self.hub.refusal is not None:
            self._reply(message, {"ok": False, "reason": self.hub.refusal})
            return
        robot = message.get("robot")
        if robot is not None and not isinstance(robot, str):
            raise MalformedError(f"robot: must be a name, not {in_short(robot)}")
        if not self.role.may_drive or not self.hub.seat.is_held_by(self.attention.key):
            self._reply(message, {"ok": False, "reason": "take control first"})
            return
        self.hub.seat.touch(self.attention.key, self.hub.clock())
        if self._preview is not None:
            self._preview.cancel()  # the newest wins

        async def work() -> None:
            try:
                answer = await self.hub.preview(stations, robot)
            except Exception as error:  # noqa: BLE001 - answered; the page continues
                self.hub.note("warn", f"dashboard: preview: {in_words(error)}")
                answer = {"ok": False, "reason": "this could not be planned"}
            self._reply(message, answer)

        self._preview = asyncio.ensure_future(work())

    def _reply(self, message: dict[str, Any], answer: dict[str, Any]) -> None:
        kind = "preview" if message.get("type") == "preview" else "answer"
        self._answer({"type": kind, "id": _number_of(message), **answer})


def _read(text: str | None) -> dict[str, Any]:
    if text is None:
        raise MalformedError("a message must be text")
    return read_object(text)


def _outcome(error: str | None) -> dict[str, Any]:
    return {"ok": True} if error is None else {"ok": False, "error": error}


def _number_of(message: dict[str, Any]) -> int | None:
    number = message.get("id")
    return number if isinstance(number, int) and abs(number) < 2**53 else None
