"""The mission's table: what it allows, what it never does, and how progress is kept."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.mission.mission import (
    TRANSITIONS,
    Event,
    MissionError,
    MissionProgress,
    State,
    Station,
    diagram,
)

TWO = (Station(0.5, 0.5), Station(1.0, 0.5, heading_rad=0.0, dwell_s=1.0))


def test_a_mission_runs_from_given_to_done() -> None:
    mission = MissionProgress().given(TWO, "go").after(Event.PLANNED, "driving").with_visited(2)
    done = mission.after(Event.ARRIVED, "at the goal")
    assert (done.state, done.remaining, done.is_over) == (State.DONE, (), True)


@pytest.mark.parametrize("state", list(State))
def test_stop_is_taken_in_every_state(state: State) -> None:
    assert TRANSITIONS[state, Event.STOP] is State.STOPPED


def test_stopped_is_left_by_hand_only() -> None:
    exits = {event for (state, event), to in TRANSITIONS.items() if state is State.STOPPED != to}
    assert exits == {Event.REARM, Event.FAIL}


@given(st.lists(st.sampled_from(list(Event)), max_size=40))
def test_no_order_of_events_drives_without_a_plan(events: list[Event]) -> None:
    mission, last = MissionProgress(TWO), None
    for event in events:
        if (mission.state, event) in TRANSITIONS:
            before, mission, last = mission.state, mission.after(event, "test"), event
            if mission.state is State.DRIVING and before is not State.DRIVING:
                assert last is Event.PLANNED
        else:
            with pytest.raises(MissionError, match="cannot take"):
                mission.after(event, "test")


def test_every_state_can_be_reached_and_left() -> None:
    reached = {State.IDLE, *TRANSITIONS.values()}
    left = {state for (state, _), to in TRANSITIONS.items() if to is not state}
    assert reached == left == set(State)


def test_visited_stations_are_never_unvisited() -> None:
    mission = MissionProgress(TWO).with_visited(1)
    assert mission.remaining == TWO[1:]
    for count in (0, 3):
        with pytest.raises(MissionError, match=r"must be in 1\.\.2"):
            mission.with_visited(count)


def test_an_errand_changes_nothing_of_what_was_visited() -> None:
    place = Station(3.0, 1.0)
    for over in (
        MissionProgress(),
        MissionProgress().given(TWO, "go").after(Event.PLANNED, "driving").arrived("there"),
    ):
        aside = over.stepping_aside(place, "aside")
        assert aside.state is State.PLANNING
        assert (aside.stations, aside.visited) == (over.stations, over.visited)
        assert aside.remaining == (place,)
        back = aside.after(Event.PLANNED, "driving").arrived("back")
        assert (back.stations, back.visited, back.remaining) == (over.stations, over.visited, ())
        assert aside.given(TWO, "a new one").remaining == TWO
    with pytest.raises(MissionError, match="stations to visit"):
        MissionProgress().given(TWO, "go").stepping_aside(place, "aside")


def test_a_mission_without_stations_is_refused() -> None:
    with pytest.raises(MissionError, match="at least one station"):
        MissionProgress().given((), "nothing")


def test_the_diagram_names_every_transition() -> None:
    assert len(list(diagram())) == 2 + len(TRANSITIONS)


def test_the_first_plan_settles_the_order_and_the_goal_stays_last() -> None:
    stations = tuple(Station(float(i), 0.0) for i in range(4))
    mission = MissionProgress().given(stations, "go", any_order=True).settled((2, 0, 1))
    assert [s.x for s in mission.stations] == [2.0, 0.0, 1.0, 3.0]
    assert mission.settled((1, 2, 0)) == mission
    with pytest.raises(MissionError, match="each of 3 stations once"):
        MissionProgress().given(stations, "go", any_order=True).settled((0, 0, 1))
