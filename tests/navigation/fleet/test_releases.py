"""Who may drive how far: gates hold until the other has passed, and never longer."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.fleet.releases import Held, Release, release_of
from navigation.fleet.request import Gate, Promise
from navigation.mission.mission import Station
from navigation.mission.targets import Target
from planner.path import Path


def promise(name: str, count: int, *gates: Gate) -> Promise:
    points = np.column_stack([np.linspace(0.0, 0.05 * count, count + 1), np.zeros(count + 1)])
    targets = tuple(Target(float(x), 0.0, 0.2, False) for x, _ in points[1:])
    path = Path(
        points=points,
        clearances=np.ones(count + 1),
        length=0.05 * count,
        min_clearance=1.0,
        min_clearance_at=(0.0, 0.0),
        robot_radius=0.1,
        stations=(0, count),
        headings_rad=(None, None),
    )
    end = Station(float(points[-1, 0]), 0.0)
    return Promise(name, end, points, targets, gates, path, None, 0.1)


def test_without_gates_all_is_released() -> None:
    assert release_of("a", {"a": Held(promise("a", 7))}) == Release(7, None)


def test_a_gate_holds_until_the_other_has_passed() -> None:
    gate = Gate(before=3, other="b", passed=5)
    held = {"a": Held(promise("a", 7, gate)), "b": Held(promise("b", 9), executed=4)}
    assert release_of("a", held) == Release(3, gate)
    held["b"].executed = 5
    assert release_of("a", held) == Release(7, None)


def test_a_robot_that_is_not_known_has_passed_nothing() -> None:
    gate = Gate(before=0, other="b", passed=0)
    assert release_of("a", {"a": Held(promise("a", 7, gate))}) == Release(0, gate)


gates = st.builds(
    Gate, before=st.integers(0, 12), other=st.sampled_from("bcd"), passed=st.integers(1, 12)
)


@given(st.lists(gates, max_size=6), st.dictionaries(st.sampled_from("bcd"), st.integers(0, 12)))
def test_the_first_closed_gate_ends_what_is_released(
    some: list[Gate], executed: dict[str, int]
) -> None:
    held = {name: Held(promise(name, 12), executed=n) for name, n in executed.items()}
    held["a"] = Held(promise("a", 12, *some))
    closed = [g.before for g in some if executed.get(g.other, -1) < g.passed]
    assert release_of("a", held).targets == min([*closed, 12])


@pytest.mark.parametrize("more", range(5))
def test_who_passes_more_never_closes_a_gate(more: int) -> None:
    some = (Gate(2, "b", 3), Gate(5, "b", 6))
    held = {"a": Held(promise("a", 8, *some)), "b": Held(promise("b", 9), executed=more)}
    before = release_of("a", held).targets
    held["b"].executed += 1
    assert release_of("a", held).targets >= before
