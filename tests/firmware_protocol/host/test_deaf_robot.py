"""A robot that reports and hears nothing is said to be deaf, and only such a one."""

from __future__ import annotations

import pytest

from firmware_protocol.host.state import LinkState
from tests.firmware_protocol.host.table import Table

KNOWN_WITHIN_S = 1.2


class HalfCut(Table):
    """A table whose line to the robot may be cut, damaged, or lose frames."""

    cut = damaged = False
    one_in = 1
    """Of so many frames one gets through."""

    def to_robot(self, data: bytes) -> list[bytes]:
        if self.cut or len(self.sent) % self.one_in:
            return []
        if self.damaged and len(data) > 8:
            return [data[:4] + bytes([data[4] ^ 0x41]) + data[5:]]
        return [data]

    def pass_s(self, seconds: float) -> list[str | None]:
        """Let time pass; each different word on why the link is down."""
        said: list[str | None] = []
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.tick()
            why = self.host.why_down(self.now_s)
            if not said or said[-1] != why:
                said.append(why)
        return said


@pytest.fixture
def table() -> HalfCut:
    table = HalfCut()
    table.pass_s(2.0)
    assert table.host.state is LinkState.STREAM
    return table


def test_a_cut_wire_to_the_robot_is_said_once_and_until_it_is_whole_again(table: HalfCut) -> None:
    table.cut = True
    first, then = table.pass_s(KNOWN_WITHIN_S)
    assert first is None
    assert "does not hear what it is sent" in str(then)
    assert "(TX)" in str(then)
    assert table.pass_s(20.0) == [then]
    table.cut = False
    assert table.pass_s(2.0)[-1] is None
    assert table.pass_s(5.0) == [None]


def test_where_only_damage_reaches_the_robot_that_is_said(table: HalfCut) -> None:
    table.damaged = True
    assert "does not understand" in str(table.pass_s(KNOWN_WITHIN_S)[-1])


def test_a_line_that_loses_half_of_the_frames_makes_no_robot_deaf(table: HalfCut) -> None:
    table.one_in = 2
    assert table.pass_s(20.0) == [None]


def test_a_program_that_gives_no_lease_makes_no_robot_deaf(table: HalfCut) -> None:
    table.lease = False
    assert table.pass_s(20.0) == [None]


def test_a_robot_that_is_silent_too_is_not_called_deaf(table: HalfCut) -> None:
    table.cable = False
    said = table.pass_s(3.0)
    assert all("hear what it is sent" not in str(why) for why in said)
    assert "no byte" in str(said[-1])


def test_a_wire_that_was_cut_before_the_link_was_made_is_named(table: HalfCut) -> None:
    table.cut = True
    table.host.close("another program opens the port")
    table.host.open(table.now_s)
    said = table.pass_s(3.0)
    assert "(TX)" in str(said[-1])
