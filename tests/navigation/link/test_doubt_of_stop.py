"""When a stop may be called one: by the robot's own word, or by its wheels'."""

from __future__ import annotations

from dataclasses import replace

import pytest

from firmware_protocol.host.state import LinkState
from navigation.link.link_snapshot import LinkSnapshot, doubt_of_stop

STANDS = LinkSnapshot(LinkState.STREAM, None, 0.01, status_age_s=0.05, estopped=True)
DRIVEN = replace(STANDS, stands=True)
SENT = "the emergency stop was sent, and it is not known yet that the robot is at rest: "


def test_a_robot_that_says_that_it_stands_in_its_stop_is_stopped() -> None:
    assert doubt_of_stop(STANDS) is None
    assert doubt_of_stop(DRIVEN) is None


@pytest.mark.parametrize(
    ("snapshot", "why"),
    [
        (replace(STANDS, estopped=False), "it has not confirmed the stop"),
        (replace(STANDS, leaving_estop=True), "it has not confirmed the stop"),
        (replace(STANDS, moving=True), "it has not been heard to stand"),
        (replace(STANDS, status_age_s=0.6), "it has not been heard to stand"),
        (replace(STANDS, down_reason="no byte has come"), "no byte has come"),
        (replace(DRIVEN, stands=False), "it has not been heard to stand"),
        (replace(DRIVEN, estopped=False), "it has not confirmed the stop"),
        (replace(DRIVEN, stands=False, down_reason="gone silent"), "gone silent"),
    ],
)
def test_what_is_not_known_is_said(snapshot: LinkSnapshot, why: str) -> None:
    assert doubt_of_stop(snapshot) == SENT + why


def test_a_robot_that_the_daemon_itself_has_stopped_needs_no_driver_to_confirm_it() -> None:
    down = replace(DRIVEN, estopped=False, down_reason="the driver has ended; the robot stands")
    assert doubt_of_stop(down) is None
