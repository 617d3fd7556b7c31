"""The thread that reads the control sockets; a stop is taken during any other work.

Rules
- The thread never waits: all clients are read as their bytes come, orders are carried out in their
  own threads, and a slow client makes way.
- If no descriptor is left, one of those held back lets the next client in.
- Clients must be of this daemon's user, or root: others are hung up on unread.

Seconds.
"""

from __future__ import annotations

import contextlib
import os
import queue
import selectors
import socket
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from navigation.control.clients import MOST_CLIENTS, Client, TooLongError, who_makes_room
from navigation.control.order_thread import Job, OrderThread
from navigation.control.peers import may_order, peer_of
from navigation.control.places import OrderSocket
from navigation.machine.descriptors import NONE_LEFT, SpareDescriptors
from navigation.mission.mission import STOPPING
from navigation.shared.outside import OutsideError, read_object
from navigation.shared.supervisor import in_words

if TYPE_CHECKING:
    from navigation.loop.people import People

ACCEPTS_A_TURN: Final = 64
SPARE: Final = 4
IDLE_S: Final = 0.2
BUSY_S: Final = 0.02
STOP_ANSWER_S: Final = 0.2
"""An executed stop is confirmed by then, whether the control loop has acted or not."""
STUCK_S: Final = 5.0
"""An order takes milliseconds: a thread at one for longer hangs."""
STOP_SENT: Final = {
    "ok": True,
    "state": STOPPING,
    "reason": "the emergency stop was sent; the control loop has not confirmed it yet",
}


class ControlServer:
    """Listens at ``path``, and without a file, in a thread; a context manager."""

    def __init__(
        self, path: Path, people: People, *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.path = path
        self.refused = 0
        """Number of malformed or refused requests."""
        self.turns = 0
        """Grows while the thread works, and the orders' threads do not hang."""
        self._people, self._clock = people, clock
        self._places = OrderSocket(path, self._watch, self._unwatch, lambda: self._spare.release())
        self._clients: list[Client] = []
        self._crash: BaseException | None = None
        self._stopping = threading.Event()

    def __enter__(self) -> ControlServer:
        self._places.open()
        self._wake_out, self._wake_in = socket.socketpair()
        for end in (self._wake_out, self._wake_in):
            end.setblocking(False)
        # here, not in the thread: there may be no descriptor left when it begins
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._wake_out, selectors.EVENT_READ, self._drain)
        for one in self._places.sockets:
            self._watch(one)
        self._spare = SpareDescriptors(SPARE)
        self._stops, self._orders = (
            OrderThread(name, self._people, self._wake, self._clock)
            for name in ("control stops", "control orders")
        )
        self._start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._stopping.set()
        self._wake()
        self._thread.join()
        self._stops.end()
        self._orders.end()
        self._spare.close()
        self._places.close()
        for one in (self._selector, self._wake_in, self._wake_out):
            one.close()

    @property
    def trouble(self) -> str:
        """Reason why orders cannot come to ``path``, if they cannot."""
        return self._places.trouble

    def news(self) -> list[str]:
        """News for people, each once."""
        found = []
        with contextlib.suppress(queue.Empty):
            while True:
                found.append(self._places.news.get_nowait())
        return found

    def failure(self) -> str | None:
        """Error that ended the thread, in words."""
        return None if self._crash is None else in_words(self._crash)

    def restart(self) -> None:
        """Start the thread again after an error."""
        self._thread.join()
        self._crash = None
        self._start()

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name="control", daemon=True)
        self._thread.start()

    def _wake(self) -> None:
        # a full pipe wakes the thread too, and a closed one has none to wake
        with contextlib.suppress(OSError):
            self._wake_in.send(b"!")

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._turn()
        except Exception as error:  # noqa: BLE001 - said by the control loop, which restarts it
            self._crash = error
        finally:
            for client in list(self._clients):
                self._forget(client)
                client.socket.close()

    def _turn(self) -> None:
        for key, _events in self._selector.select(BUSY_S if self._clients else IDLE_S):
            key.data()
        now_s = self._clock()
        for client in list(self._clients):
            self._look_after(client, now_s)
        self._spare.refill()
        self._places.look(now_s)
        if max(self._stops.busy_s(now_s), self._orders.busy_s(now_s)) < STUCK_S:
            self.turns += 1

    def _drain(self) -> None:
        with contextlib.suppress(BlockingIOError):
            self._wake_out.recv(4096)

    def _watch(self, listening: socket.socket) -> None:
        self._selector.register(listening, selectors.EVENT_READ, partial(self._accept, listening))

    def _unwatch(self, listening: socket.socket) -> None:
        self._selector.unregister(listening)

    def _accept(self, listening: socket.socket) -> None:
        for _ in range(ACCEPTS_A_TURN):
            try:
                connection, _ = listening.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                if error.errno not in NONE_LEFT:
                    raise
                if not self._make_room():
                    return
                continue
            if not may_order(peer_of(connection)):
                connection.close()  # so that it takes no client's place
                continue
            if len(self._clients) >= MOST_CLIENTS:
                self._drop_one()
            connection.setblocking(False)
            client = Client(connection, self._clock())
            self._clients.append(client)
            self._selector.register(connection, selectors.EVENT_READ, partial(self._read, client))
            self._read(client)  # most have sent their line before they are let in

    def _make_room(self) -> bool:
        if self._spare.release():
            return True
        if self._clients:
            self._drop_one()
            return True
        return False

    def _drop_one(self) -> None:
        self.refused += 1
        sentence = f"more than {MOST_CLIENTS} clients: this one made room for a newer one"
        answer = {"ok": False, "error": sentence, "again": True}
        self._hang_up(who_makes_room(self._clients), answer)

    def _hang_up(self, client: Client, answer: dict[str, Any]) -> None:
        self._forget(client)
        client.answer({**answer, "socket": os.path.abspath(self.path)})

    def _forget(self, client: Client) -> None:
        self._clients.remove(client)
        if client.job is None:  # else nothing more is read from it already
            self._selector.unregister(client.socket)

    def _read(self, client: Client) -> None:
        if client not in self._clients:  # it made way a moment ago
            return
        try:
            line = client.read()
            if line is None:
                return
            if not line:  # it came and went without a word
                raise ConnectionResetError
            job = Job(read_object(line), self._clock())
        except (TooLongError, OutsideError) as error:
            self._refuse(client, str(error))
            return
        except OSError:  # only the order of a client that hangs up is dropped
            self._forget(client)
            client.socket.close()
            return
        self._selector.unregister(client.socket)
        client.job = job
        thread = self._stops if job.is_stop else self._orders
        if not thread.put(job):
            self._refuse(client, "too many orders wait already")

    def _refuse(self, client: Client, sentence: str) -> None:
        self.refused += 1
        self._hang_up(client, {"ok": False, "error": sentence})

    def _look_after(self, client: Client, now_s: float) -> None:
        job = client.job
        if job is not None and job.answer is not None and job.done:
            self.refused += not job.answer["ok"]
            self._hang_up(client, job.answer)
        elif job is not None and _is_due(job, now_s):
            self._hang_up(client, {**STOP_SENT, **_trouble_of(job)})
        elif (sentence := client.late(now_s)) is not None:
            self._refuse(client, sentence)


def _is_due(job: Job, now_s: float) -> bool:
    if not job.is_stop or now_s - job.came_s < STOP_ANSWER_S:
        return False
    return job.answer is not None and bool(job.answer["ok"])


def _trouble_of(job: Job) -> dict[str, Any]:
    return {key: said for key, said in (job.answer or {}).items() if key == "trouble"}
