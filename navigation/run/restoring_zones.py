"""The zones that people changed in an earlier run, restored from beside the journal.

A run that begins again with a changed configuration has them from the run before, too: without a
journal, or with a disk that was full, a reload loses none. If the file is damaged, the
configuration's zones hold, and all robots are stopped until a person resumes: a keep-out zone may
be lost with it. The damaged file is put aside only when that stop is on the disk, so that a run
killed in between does not drive either.
"""

from __future__ import annotations

from collections.abc import Callable

from navigation.journal.kept_zones import KeptZones, KeptZonesError
from navigation.loop.daemon import Daemon
from navigation.loop.zones_in_force import ZonesInForce
from navigation.machine.logs import RunLog


class RestoredZones:
    """Zones of an earlier run, taken over before anyone can change them."""

    def __init__(
        self,
        daemon: Daemon,
        say: Callable[[str], None],
        log: RunLog,
        before: ZonesInForce | None = None,
    ) -> None:
        self._daemon, self._say, self._log = daemon, say, log
        self._lost: KeptZones | None = None
        journal = daemon.config.recording.journal
        kept = None if journal is None else KeptZones.beside(journal)
        try:
            said = daemon.zones.restore(kept, before)
        except KeptZonesError as error:
            self._lost = kept
            lost = f"changes of zones are lost: {error}; check the zones before `clearway resume`"
            daemon.people.stop(lost)
            said = [lost]
        for sentence in said:
            self._tell(sentence)

    def settle(self) -> None:
        """Put a damaged file aside, and keep changes from now on; call it once stops are kept."""
        if self._lost is None:
            return
        stops = self._daemon.stopping.kept
        if stops is not None and stops.settled():
            return  # the stop is not on the disk: the damage stops the next run too
        try:
            self._tell(self._lost.put_aside())
        except KeptZonesError as error:
            self._tell(str(error))  # nothing is written over it
        else:
            self._daemon.zones.keep_in(self._lost)

    def _tell(self, sentence: str) -> None:
        self._say(sentence)
        self._log.write("warning", "zones", reason=sentence)
