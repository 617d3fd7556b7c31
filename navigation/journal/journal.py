"""State that survives a restart: the mission, its progress and the robot's plan.

Rules
- Everything is synced before it takes effect: a mission before it is planned, a plan before its
  first waypoint is sent, a visited station before anything relies on it.
- A restart never resumes a stopped, done or failed mission by itself, nor a re-armed one, which
  waits for an order. A paused one stays paused.
- A journal that cannot be written ends no run: `trouble` reports it, it is tried again every
  ``RETRY_S``, and a deleted file is made again. A file that only lacks stations visited meanwhile
  stays; one that would make a restart drive a stopped, finished or replaced mission is removed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from navigation.journal.journal_file import JournalFile
from navigation.journal.journal_lock import OPEN_WITHIN_S, JournalError, JournalWriteError
from navigation.journal.journal_records import Contents, Owner, SentPlan, owner_of
from navigation.mission.mission import MissionProgress, State, Station

__all__ = ["Journal", "JournalError", "Owner", "SentPlan", "owner_of"]

RETRY_S: Final = 1.0
_GOES_ON: Final = (State.PLANNING, State.PROVING, State.DRIVING, State.HOLDING)


class Journal:
    """One journal; a context manager whose constructor opens everything. One thread.

    ``JournalError`` if the file must not be used: another program holds it, it is no journal or of
    another version, or it is forbidden. ``remark`` says what was put aside.
    """

    def __init__(self, path: Path, owner: Owner) -> None:
        self.path, self.owner = path, owner
        self.remark = self.trouble = ""
        self._file: JournalFile | None = None
        self._kept: Contents | None = None
        self._failed: Contents | None = None
        self._retry_s = 0.0
        try:
            self._open(OPEN_WITHIN_S)
        except JournalWriteError as error:
            self.trouble = _in_words(error)

    def _open(self, patience_s: float) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None
        self._file = JournalFile(self.path, self.owner, patience_s)
        self.remark = self._file.remark
        if self._kept is None:
            self._kept = self._file.contents

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_exc: object) -> None:
        if self._file is not None:
            self._file.close()

    def mission(self) -> MissionProgress | None:
        """Last mission stored, if any."""
        return None if self._kept is None else self._kept.mission

    def plan(self) -> SentPlan | None:
        """Last plan stored of this mission, if any."""
        return None if self._kept is None else self._kept.plan

    def unfinished(self) -> MissionProgress | None:
        """Mission that a restart must continue; None if nothing is left to do."""
        mission = self.mission()
        return mission if mission is not None and _has_work(mission) else None

    def rearmed(self) -> MissionProgress | None:
        """Mission that was stopped and re-armed, and not resumed since."""
        mission = self.mission()
        waits = mission is not None and mission.state is State.IDLE and bool(mission.remaining)
        return mission if waits else None

    def keep(self, mission: MissionProgress, sent: SentPlan | None, now_s: float) -> None:
        """Store the mission with its progress, and ``sent``, the plan about to be given.

        A plan is kept until the next plan, mission or errand. Never raises: see `trouble`.
        """
        known = self._failed or self._kept
        if sent is None and known is not None and _is_for(known.mission, mission):
            sent = known.plan
        wanted = Contents(self.owner, mission, sent)
        if self._failed is None and self._kept is not None and _is_same(wanted, self._kept):
            return
        if self._failed is not None and _is_same(wanted, self._failed) and now_s < self._retry_s:
            return
        try:
            self._write(wanted)
        except JournalError as error:
            self.trouble = _in_words(error)
            self._failed, self._retry_s = wanted, now_s + RETRY_S
            self._drop_what_misleads(mission)
        else:
            self.trouble = ""
            self._failed, self._kept = None, wanted

    def _write(self, wanted: Contents) -> None:
        if self._file is not None:
            try:
                self._file.save(wanted)
            except JournalWriteError:
                if self._failed is None:
                    raise  # reported first: its deletion may have had a reason
            else:
                return
        self._open(patience_s=0.0)  # the control loop never waits
        assert self._file is not None
        self._file.save(wanted)

    def _drop_what_misleads(self, mission: MissionProgress) -> None:
        kept = self._kept
        if self._file is None or kept is None or not _has_work(kept.mission):
            return
        is_progress = kept.mission.stations == mission.stations and _has_work(mission)
        if not is_progress or kept.mission.paused != mission.paused:
            self._file.discard()


def _has_work(mission: MissionProgress) -> bool:
    return mission.state in _GOES_ON and bool(mission.remaining)


def _is_for(one: MissionProgress, other: MissionProgress) -> bool:
    """True if a plan of one leads through the places of the other."""
    return one.stations is other.stations and one.errand is other.errand


def _is_same(one: Contents, other: Contents) -> bool:
    """True if a restart would do the same; the sentences may differ."""
    return one.plan is other.plan and _progress(one.mission) == _progress(other.mission)


def _progress(m: MissionProgress) -> tuple[tuple[Station, ...], int, bool, State, bool]:
    return m.places, m.visited, m.any_order, m.state, m.paused


def _in_words(error: JournalError) -> str:
    return f"{error}; the run continues, and a restart would not know of it"
