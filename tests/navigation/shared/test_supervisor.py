"""Failed parts are started again with growing pauses, and that is said."""

from __future__ import annotations

import pytest

from navigation.shared.supervisor import LONGEST_PAUSE_S, SupervisedPart, Supervisor, in_words


class Fragile:
    """A part that fails when told, or again and again."""

    def __init__(self) -> None:
        self.broken: str | None = None
        self.restarts: list[float] = []
        self.incurable = False
        self.now_s = 0.0

    def restart(self) -> None:
        self.restarts.append(self.now_s)
        if not self.incurable:
            self.broken = None


@pytest.fixture
def part() -> Fragile:
    return Fragile()


@pytest.fixture
def supervisor(part: Fragile) -> Supervisor:
    return Supervisor({"planner": SupervisedPart(lambda: part.broken, part.restart)})


def look(supervisor: Supervisor, part: Fragile, until_s: float) -> list[str]:
    """Look every 50 ms; the different things that were said."""
    said = []
    while part.now_s < until_s:
        part.now_s = round(part.now_s + 0.05, 6)
        sentence = supervisor.look(part.now_s)
        if sentence is not None and sentence not in said:
            said.append(sentence)
    return said


def test_a_part_that_is_well_is_left_alone(supervisor: Supervisor, part: Fragile) -> None:
    assert look(supervisor, part, 10.0) == []
    assert part.restarts == []


def test_a_failed_part_is_said_and_started_again_soon(
    supervisor: Supervisor, part: Fragile
) -> None:
    part.broken = "ValueError: out of range"
    assert look(supervisor, part, 5.0) == [
        "the planner failed (ValueError: out of range): starting it again"
    ]
    assert part.restarts == pytest.approx([0.3])
    assert supervisor.restarts == 1


def test_one_that_fails_again_and_again_never_crash_loops(
    supervisor: Supervisor, part: Fragile
) -> None:
    part.broken, part.incurable = "ValueError", True
    look(supervisor, part, 120.0)
    pauses = [b - a for a, b in zip(part.restarts, part.restarts[1:], strict=False)]
    assert pauses[:3] == pytest.approx([0.55, 1.05, 2.05], abs=0.06)
    assert max(pauses) == pytest.approx(LONGEST_PAUSE_S, abs=0.11)
    assert len(part.restarts) < 25


def test_after_a_good_while_the_pause_is_short_again(supervisor: Supervisor, part: Fragile) -> None:
    part.incurable, part.broken = True, "ValueError"
    look(supervisor, part, 20.0)
    part.incurable, part.broken = False, None
    look(supervisor, part, 80.0)
    count = len(part.restarts)
    part.broken = "KeyError"
    look(supervisor, part, 81.0)
    assert len(part.restarts) == count + 1
    assert part.restarts[-1] == pytest.approx(80.3)


def test_an_error_is_told_in_its_first_line() -> None:
    assert in_words(ValueError("one\ntwo")) == "ValueError: one"
    assert in_words(KeyError()) == "KeyError"


def test_a_part_that_came_later_is_looked_after_too(supervisor: Supervisor, part: Fragile) -> None:
    later = Fragile()
    supervisor.add("control socket", SupervisedPart(lambda: later.broken, later.restart))
    later.broken = "ValueError"
    assert look(supervisor, part, 1.0) == [
        "the control socket failed (ValueError): starting it again"
    ]
    assert later.broken is None
