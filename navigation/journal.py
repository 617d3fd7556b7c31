"""What must survive a restart: the mission, its progress and the plan that the robot holds.

Rules
- Everything is written and synced before it takes effect: a mission before it is planned for,
  a plan before its first waypoint goes out, a visited station before anything relies on it.
- SQLite in WAL mode with ``synchronous=FULL``: a kill at any moment loses nothing that was
  said to be saved, and never leaves half a record.
- One row each: the journal holds the present, not history.
- A mission that was stopped, done or failed is over, and one that was re-armed waits for an
  order: a restart never resumes them by itself. A paused one stays paused.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

from navigation.mission import Mission, State, Station
from navigation.targets import Target

_T = TypeVar("_T")

VERSION: Final = 1
_TABLES: Final = """
CREATE TABLE IF NOT EXISTS mission (one INTEGER PRIMARY KEY CHECK (one = 1), body TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS plan (one INTEGER PRIMARY KEY CHECK (one = 1), body TEXT NOT NULL);
"""


class JournalError(ValueError):
    """The journal cannot be used; the message says which file and why."""


@dataclass(frozen=True, slots=True)
class SentPlan:
    """A plan as it was given to the robot: its id on the wire and where in the mission it began."""

    mission_id: int
    visited_before: int
    targets: tuple[Target, ...]

    def visited_after(self, executed: int) -> int:
        """How many stations are visited when the robot has executed so many targets."""
        passed = [t.station for t in self.targets[:executed] if t.station is not None]
        return self.visited_before + max(passed, default=0)


class Journal:
    """One journal file; a context manager. Not for several threads."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._db = sqlite3.connect(path, isolation_level=None, timeout=2.0)
            self._prepare()
        except (OSError, sqlite3.Error) as error:
            raise JournalError(f"journal {path}: {error}") from None

    def _prepare(self) -> None:
        self._db.execute("PRAGMA journal_mode=WAL")
        self._db.execute("PRAGMA synchronous=FULL")
        found = int(self._db.execute("PRAGMA user_version").fetchone()[0])
        if found not in (0, VERSION):
            self._db.close()
            raise JournalError(
                f"journal {self.path}: is of version {found}, this program writes {VERSION}"
            )
        self._db.executescript(_TABLES)
        self._db.execute(f"PRAGMA user_version={VERSION}")

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_exc: object) -> None:
        self._db.close()

    def save_mission(self, mission: Mission) -> None:
        """Keep the mission with its progress, in place of what was kept before."""
        self._save("mission", {**asdict(mission), "state": mission.state.name})

    def save_plan(self, plan: SentPlan) -> None:
        """Keep what the robot is about to be given."""
        self._save("plan", asdict(plan))

    def mission(self) -> Mission | None:
        """The mission that was kept last; None where there is none."""
        return self._load("mission", _mission)

    def plan(self) -> SentPlan | None:
        """The plan that was kept last; None where there is none."""
        return self._load("plan", _plan)

    def unfinished(self) -> Mission | None:
        """The mission that a restart has to go on with; None where nothing is left to do."""
        mission = self.mission()
        goes_on = (State.PLANNING, State.PROVING, State.DRIVING, State.HOLDING)
        if mission is None or mission.state not in goes_on or not mission.remaining:
            return None
        return mission

    def _save(self, table: str, body: dict[str, Any]) -> None:
        text = json.dumps(body, allow_nan=False)
        try:
            self._db.execute(f"INSERT OR REPLACE INTO {table} VALUES (1, ?)", (text,))
        except sqlite3.Error as error:
            raise JournalError(f"journal {self.path}: cannot write: {error}") from None

    def _load(self, table: str, read: Callable[[dict[str, Any]], _T]) -> _T | None:
        try:
            row = self._db.execute(f"SELECT body FROM {table}").fetchone()
            return None if row is None else read(json.loads(row[0]))
        except (sqlite3.Error, ValueError, KeyError, TypeError) as error:
            raise JournalError(
                f"journal {self.path}: its {table} cannot be read: {error}"
            ) from None


def _mission(body: dict[str, Any]) -> Mission:
    stations = tuple(Station(**station) for station in body["stations"])
    return Mission(
        stations,
        int(body["visited"]),
        bool(body["any_order"]),
        State[body["state"]],
        body["reason"],
        bool(body.get("paused", False)),
    )


def _plan(body: dict[str, Any]) -> SentPlan:
    targets = tuple(Target(**target) for target in body["targets"])
    return SentPlan(int(body["mission_id"]), int(body["visited_before"]), targets)
