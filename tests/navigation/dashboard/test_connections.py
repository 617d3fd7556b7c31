"""Who has a place at the page's port, who makes room, and who is cut for being late."""

from math import inf

import pytest

from navigation.dashboard.admission.connections import (
    CLOSE_WITHIN_S,
    OpenConnection,
    OpenConnections,
)

HERE, THERE = "127.0.0.1", "192.0.2.7"


class Line:
    """A connection that notes when it is cut."""

    def __init__(self) -> None:
        self.is_cut = self.closing = False

    def abort(self) -> None:
        self.is_cut = True

    def is_closing(self) -> bool:
        return self.closing


def come(
    places: OpenConnections, address: str = HERE, until_s: float = 5.0
) -> tuple[OpenConnection, Line]:
    line = Line()
    place = OpenConnection(line, address, until_s)
    places.come(place)
    return place, line


def test_where_all_places_are_taken_the_oldest_makes_room() -> None:
    places = OpenConnections(3, 3)
    lines = [come(places)[1] for _ in range(5)]
    assert [line.is_cut for line in lines] == [True, True, False, False, False]
    assert (len(places), places.cut) == (3, 2)


def test_an_address_makes_room_for_itself_first() -> None:
    places = OpenConnections(10, 2)
    other = come(places, THERE)[1]
    lines = [come(places)[1] for _ in range(4)]
    assert [line.is_cut for line in lines] == [True, True, False, False]
    assert not other.is_cut


def test_a_viewer_is_never_cut_for_a_connection_and_takes_no_place_from_them() -> None:
    places = OpenConnections(2, 2)
    viewer, line = come(places)
    places.look(viewer)
    assert viewer.until_s == inf
    for _ in range(5):
        come(places)
    assert not line.is_cut
    assert len(places) == 3
    places.sweep(1e9)
    assert not line.is_cut


def test_who_is_late_is_cut_and_who_ended_is_forgotten() -> None:
    places = OpenConnections(9, 9)
    late, punctual = come(places, until_s=5.0)[1], come(places, until_s=7.0)[1]
    ended, line = come(places, until_s=5.0)
    places.go(ended)
    places.go(ended)
    places.sweep(5.1)
    assert (late.is_cut, punctual.is_cut, line.is_cut) == (True, False, False)
    assert len(places) == 1


def test_a_viewer_that_does_not_take_the_last_words_is_cut() -> None:
    places = OpenConnections(9, 9)
    viewer, line = come(places)
    places.look(viewer)
    line.closing = True
    places.sweep(100.0)
    assert not line.is_cut
    places.sweep(100.0 + CLOSE_WITHIN_S + 0.1)
    assert line.is_cut


@pytest.mark.parametrize("ending", ["cut", "gone"])
def test_a_share_is_given_back(ending: str) -> None:
    places = OpenConnections(9, 1)
    for _ in range(3):
        place, line = come(places, until_s=1.0)
        assert not line.is_cut
        places.sweep(2.0) if ending == "cut" else places.go(place)
    assert len(places) == 0
