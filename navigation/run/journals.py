"""The journals of a run, one for each robot, and the lock of the zones' file beside them.

That file belongs to `recording.journal` itself, which is the journal of one robot; several have
theirs under names of their own. Without its lock, a program with other robots would write its own
changes of zones over a keep-out zone that a person had drawn here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path

from navigation.config import Config
from navigation.journal.journal import Journal, owner_of
from navigation.journal.journal_lock import JournalLock, JournalWriteError


def open_journals(
    config: Config,
    robots: Mapping[str, Config],
    file: Path | None,
    open_things: ExitStack,
    warn: Callable[[str, str], None],
) -> dict[str, Journal]:
    """Open each robot's journal, by its name; ``JournalError`` if another program has one.

    ``warn`` gets a robot's name, empty for none, and a sentence.
    """
    paths = {name: one.recording.journal for name, one in robots.items()}
    common = config.recording.journal
    if common is not None and common not in paths.values():
        try:
            open_things.enter_context(JournalLock(common))
        except JournalWriteError as error:
            warn("", f"{error}; the run continues, and another program may use it too")
    journals = {}
    for name, path in paths.items():
        if path is None:
            continue
        journals[name] = open_things.enter_context(Journal(path, owner_of(robots[name], file)))
        for sentence in filter(None, (journals[name].remark, journals[name].trouble)):
            warn(name, sentence)
    return journals
