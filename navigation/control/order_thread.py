"""A thread that carries out all waiting orders at once. Seconds of the given clock."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from navigation.orders.carry_out import carry_out
from navigation.orders.table import ORDERS
from navigation.shared.supervisor import in_words

if TYPE_CHECKING:
    from navigation.loop.people import People

MOST_WAITING: Final = 64


@dataclass(slots=True, eq=False)
class Job:
    """One request; ``answer`` is set once it was carried out, ``done`` once it is final."""

    request: dict[str, Any]
    came_s: float
    answer: dict[str, Any] | None = None
    done: bool = False

    @property
    def is_stop(self) -> bool:
        """True if it asks for the emergency stop."""
        return self.request.get("order") == "stop"


class OrderThread:
    """Carries out jobs from `put`; calls ``on_done`` from the thread."""

    def __init__(
        self,
        name: str,
        people: People,
        on_done: Callable[[], None],
        clock: Callable[[], float],
    ) -> None:
        self._people, self._on_done, self._clock = people, on_done, clock
        self._jobs: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._since_s: float | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, job: Job) -> bool:
        """Queue a job; False if too many wait already."""
        if self._jobs.qsize() >= MOST_WAITING:
            return False
        self._jobs.put(job)
        return True

    def busy_s(self, now_s: float) -> float:
        """Time at its present work; 0 while it waits for some."""
        since_s = self._since_s
        return 0.0 if since_s is None else now_s - since_s

    def end(self) -> None:
        """End the thread after its present jobs."""
        self._jobs.put(None)

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            self._since_s = self._clock()
            batch = [job]
            while not self._jobs.empty():
                following = self._jobs.get()
                if following is None:
                    self._jobs.put(None)  # for the next time round
                    break
                batch.append(following)
            self._carry_out(batch)
            self._since_s = None
            self._on_done()

    def _carry_out(self, batch: list[Job]) -> None:
        for job in batch:
            try:
                job.answer = carry_out(job.request, self._people)
            except Exception as error:  # noqa: BLE001 - answered; the next order is taken
                job.answer = _failed(error)
        acted = [job for job in batch if job.answer and job.answer["ok"] and _acts(job)]
        try:
            if acted:
                # what the orders led to, not the state before them
                self._people.settle()
                now = self._people.describe()
                for job in acted:
                    job.answer = {**(job.answer or {}), **now}
        except Exception as error:  # noqa: BLE001 - answered; the next order is taken
            for job in acted:
                job.answer = _failed(error)
        for job in batch:
            job.done = True


def _acts(job: Job) -> bool:
    return not ORDERS[job.request["order"]].only_looks


def _failed(error: Exception) -> dict[str, Any]:
    return {"ok": False, "error": f"the program failed at it: {in_words(error)}"}
