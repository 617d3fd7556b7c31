"""The journal: nothing that was saved is lost, and nothing that cannot be trusted is driven."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.journal.journal import Journal, SentPlan
from navigation.mission.mission import Event, MissionProgress, State, Station
from navigation.mission.targets import Target
from tests.navigation.journal.kept import DRIVING, OWNER, PLAN, TWO, keep

numbers = st.floats(-1e3, 1e3)
headings = st.none() | st.floats(-3.14, 3.14)
dwells = st.floats(0.0, 3600.0)
stations = st.builds(Station, numbers, numbers, headings, dwells)
targets = st.builds(
    Target, numbers, numbers, st.floats(0.0, 5.0), st.booleans(), headings, dwells, st.none()
)
under_way = st.lists(stations, min_size=1, max_size=5).flatmap(
    lambda s: st.builds(
        MissionProgress,
        st.just(tuple(s)),
        st.integers(0, len(s)),
        st.booleans(),
        st.sampled_from(State),
        st.text(max_size=20),
    )
)
on_errands = st.builds(
    lambda mission, place: replace(mission, visited=len(mission.stations), errand=place),
    under_way,
    stations,
)
done = st.just(MissionProgress(state=State.DONE, reason="its only station was taken from it"))
missions = under_way | on_errands | done


@given(missions, st.lists(targets, max_size=5), st.integers(1, 2**32 - 1))
def test_what_is_saved_is_read_back_exactly(
    tmp_path_factory: pytest.TempPathFactory,
    mission: MissionProgress,
    some: list[Target],
    number: int,
) -> None:
    path = tmp_path_factory.mktemp("journal") / "journal"
    plan = SentPlan(number, 0, tuple(some))
    keep(path, mission, plan)
    with Journal(path, OWNER) as journal:
        assert journal.mission() == mission
        assert journal.plan() == plan


def test_only_an_unfinished_mission_is_gone_on_with(path: Path) -> None:
    with Journal(path, OWNER) as journal:
        assert journal.unfinished() is None
        journal.keep(DRIVING, None, 0.0)
        assert journal.unfinished() == DRIVING
        for event in (Event.STOP, Event.FAIL):
            journal.keep(DRIVING.after(event, "over"), None, 0.0)
            assert journal.unfinished() is None
        journal.keep(replace(DRIVING, visited=2), None, 0.0)
        assert journal.unfinished() is None


def test_the_robot_s_progress_counts_stations_of_the_plan_it_holds() -> None:
    row = tuple(
        Target(float(i), 0.0, 0.3, False, station=s) for i, s in enumerate([None, 1, None, 2])
    )
    plan = SentPlan(7, 3, row)
    assert [plan.visited_after(n) for n in range(5)] == [3, 3, 4, 4, 5]


def test_the_plan_of_an_errand_is_forgotten_with_it(path: Path) -> None:
    """The robot has driven to one place more than the mission has: no record may say so."""
    over = DRIVING.arrived("there")
    aside = over.stepping_aside(TWO[1], "aside")
    there = SentPlan(10, 2, (Target(2.0, 1.0, 0.0, True, station=1),))
    with Journal(path, OWNER) as journal:
        journal.keep(aside, there, 0.0)
    with Journal(path, OWNER) as journal:
        assert (journal.remark, journal.unfinished(), journal.plan()) == ("", aside, there)
        back = aside.after(Event.PLANNED, "driving").arrived("back")
        journal.keep(back, None, 0.0)
    with Journal(path, OWNER) as journal:
        assert (journal.remark, journal.mission(), journal.plan()) == ("", back, None)
        assert journal.unfinished() is None


def test_the_plan_of_another_mission_is_forgotten_with_it(path: Path) -> None:
    """The robot's progress on the old plan says nothing about the new mission's stations."""
    with Journal(path, OWNER) as journal:
        journal.keep(DRIVING, PLAN, 0.0)
        journal.keep(DRIVING.with_visited(2), None, 0.0)
        assert journal.plan() == PLAN
        journal.keep(DRIVING.given((TWO[1], TWO[0]), "again"), None, 0.0)
        assert journal.plan() is None
    with Journal(path, OWNER) as journal:
        assert journal.plan() is None
