"""The zones that people changed in an earlier run: restored from beside the journal."""

from __future__ import annotations

from collections.abc import Callable

from navigation.journal.kept_zones import KeptZones, KeptZonesError
from navigation.loop.daemon import Daemon
from navigation.machine.logs import RunLog


def restore_zones(daemon: Daemon, say: Callable[[str], None], log: RunLog) -> None:
    """Begin with the zones as an earlier run left them, and keep further changes.

    If they are lost, a keep-out zone may be lost with them: the configuration's zones hold, and all
    robots are stopped until a person resumes. Without a journal nothing is restored or kept.
    """
    journal = daemon.config.recording.journal
    if journal is None:
        return
    try:
        said = daemon.zones.restore(KeptZones.beside(journal))
    except KeptZonesError as error:
        lost = f"changes of zones are lost: {error}; check the zones before `clearway resume`"
        daemon.people.stop(lost)  # stored with the other stops, as soon as these are looked at
        said = [lost]
    for sentence in said:
        say(sentence)
        log.write("warning", "zones", reason=sentence)
