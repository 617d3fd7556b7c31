"""A mission that is driven, whose it is, and how a test keeps it; a zone."""

from collections.abc import Sequence
from pathlib import Path

from navigation.config.zones import ZoneSection
from navigation.journal.journal import Journal, SentPlan
from navigation.journal.journal_records import Owner
from navigation.mission.mission import Event, MissionProgress, Station
from navigation.mission.targets import Target

OWNER = Owner(robot="7 of DICT_4X4_50", port="simulated", camera="a", configuration="/etc/a.yaml")
TWO = (Station(1.0, 1.0), Station(2.0, 1.0))
DRIVING = MissionProgress().given(TWO, "go").after(Event.PLANNED, "driving").with_visited(1)
PLAN = SentPlan(9, 0, (Target(1.0, 1.0, 0.3, True, station=1), Target(2.0, 1.0, 0.0, True)))


def keep(path: Path, mission: MissionProgress = DRIVING, plan: SentPlan | None = PLAN) -> None:
    with Journal(path, OWNER) as journal:
        journal.keep(mission, plan, 0.0)
        assert journal.trouble == ""


def aside(path: Path) -> list[str]:
    """Every file beside the lock."""
    return sorted(file.name for file in path.parent.iterdir() if file.name != f".{path.name}.lock")


def circle(
    name: str, kind: str = "keep_out", *, x_m: float = 1.0, robots: Sequence[str] = ()
) -> ZoneSection:
    """A zone as it is written in a configuration."""
    area = {"name": name, "kind": kind, "circle": [x_m, 1.0, 0.2], "robots": robots}
    return ZoneSection.model_validate(area)
