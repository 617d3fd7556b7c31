"""The whole program in virtual time: a run as the command line makes it, to its exit code.

Only the world, the waiting and the kernels' warm-up are others than in `clearway run`: journal,
log of events, control socket, notes to systemd and report are those of the program.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from navigation.config import Config
from navigation.control import send_order
from navigation.machine.sd_notify import Notifier
from navigation.run import runner
from navigation.run.runner import EVENTS_FILE, Runner
from tests.support.runs.troubled_world import TroubledWorld

Happening = Callable[[TroubledWorld], None]


@dataclass(slots=True)
class WholeRun:
    """What a run left behind, and what it said meanwhile."""

    exit_code: int = 0
    folder: Path = Path()
    report: dict[str, Any] = field(default_factory=dict)
    events: list[dict[str, Any]] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    notified: list[str] = field(default_factory=list)
    """To systemd."""
    answers: list[dict[str, Any]] = field(default_factory=list)
    """Of the control socket, in the order of the questions."""

    def events_called(self, name: str) -> list[dict[str, Any]]:
        """Those of one name."""
        return [one for one in self.events if one["event"] == name]


class Told(Notifier):
    """Keeps what is sent to systemd."""

    def __init__(self, kept: list[str]) -> None:
        super().__init__(None)
        self._kept = kept

    def send(self, *assignments: str) -> bool:
        """Keep it."""
        self._kept.extend(assignments)
        return True


class _Clock:
    lost_s = 0.0

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now

    def __call__(self) -> float:
        return self._now()


def run_whole(
    config: Config,
    folder: Path,
    patch: pytest.MonkeyPatch,
    at: Mapping[float, Happening | dict[str, Any]] | None = None,
    *,
    dashboard: bool = False,
    interrupted: bool = False,
    file: Path | None = None,
) -> WholeRun:
    """Run the configuration with ``once``; ``at`` seconds something happens, or an order is given.

    What the run leaves behind is in ``folder``. ``interrupted``: before it has begun. ``file`` is
    the configuration's.
    """
    ran, socket = WholeRun(), folder / "control.sock"

    def happen(world: TroubledWorld, what: Happening | dict[str, Any]) -> None:
        if isinstance(what, dict):
            ran.answers.append(send_order(socket, what))
        else:
            what(world)

    def opened(world: TroubledWorld) -> TroubledWorld:
        for after_s, what in (at or {}).items():
            world.after(after_s, partial(happen, world, what))
        for member, value in (("clock", _Clock(world.clock)), ("doubts", [])):
            setattr(world, member, value)
        return world

    def make(config: Config, **_: Any) -> TroubledWorld:
        return opened(TroubledWorld(config, pictures=False))

    patch.setattr(runner, "World", make)
    patch.setattr(runner, "warm_up", lambda *_: None)
    recording = config.recording.model_copy(update={"runs_dir": folder / "runs"})
    config = config.model_copy(update={"recording": recording})
    driven = Runner(
        config,
        once=True,
        file=file,
        say=ran.said.append,
        socket=socket,
        dashboard=dashboard,
        notifier=Told(ran.notified),
    )
    if interrupted:
        driven.interrupt.set()
    ran.exit_code = driven.run().exit_code
    (left,) = (folder / "runs").iterdir()
    ran.folder = left
    ran.report = json.loads((left / "report.json").read_text())
    ran.events = [json.loads(line) for line in (left / EVENTS_FILE).read_text().splitlines()]
    return ran
