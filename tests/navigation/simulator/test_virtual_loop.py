"""A virtual loop that asks each end only when due, against one that asks every millisecond."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict

import pytest

from firmware_protocol.wire.messages import StopReason, Waypoint, WaypointFlag
from firmware_protocol.wire.mission import Mission
from navigation.simulator.line_faults import FaultSpec
from tests.support.runs.scenario_loop import ScenarioLoop

LINE = Mission(7, [*(Waypoint(0.05 * i, 0.0, 0.2) for i in range(1, 12)),
                   Waypoint(0.6, 0.0, 0.2, flags=WaypointFlag.STOP)])  # fmt: skip
STEPS_S = 0.25
"""Between two looks at the trouble of a run."""

Trouble = Callable[[ScenarioLoop, int], None]


def _none(_loop: ScenarioLoop, _step: int) -> None:
    pass


def _cut_cable(loop: ScenarioLoop, step: int) -> None:
    loop.knobs.cable = not 8 <= step < 14


def _cut_wire_to_robot(loop: ScenarioLoop, step: int) -> None:
    loop.knobs.to_robot = not 8 <= step < 20


def _silence_camera(loop: ScenarioLoop, step: int) -> None:
    loop.knobs.camera = not 8 <= step < 14


def _withdraw_permit(loop: ScenarioLoop, step: int) -> None:
    loop.knobs.permit = not 8 <= step < 10


def _freeze_processor(loop: ScenarioLoop, step: int) -> None:
    loop.knobs.frozen = 8 <= step < 13


def _press_button(loop: ScenarioLoop, step: int) -> None:
    if step == 8:
        loop.robot.controller.emergency_stop(StopReason.ESTOP_LOCAL)
    elif step == 14:
        loop.host.reset_estop(loop.now_s)


def _stop_and_pause(loop: ScenarioLoop, step: int) -> None:
    if step == 7:
        loop.host.pause()
    elif step == 10:
        loop.host.start(loop.now_s)
    elif step == 12:
        loop.host.estop()


def _run(trouble: Trouble, faults: str, *, always: bool) -> tuple[object, ...]:
    loop = ScenarioLoop(seed=5, faults=FaultSpec.parse(faults), robot_clock_drift=1e-4)
    for step in range(36):
        if step == 4:
            loop.host.upload(LINE, loop.now_s)
        trouble(loop, step)
        end_s = loop.now_s + STEPS_S
        while loop.now_s < end_s:
            if always:
                assert loop.host is not None
                assert loop.robot is not None  # taken from the loop, so due
            loop.tick()
    host = loop.host
    return loop.track, loop.events, asdict(host.counters), asdict(host.parser.counters), host.status


@pytest.mark.parametrize("faults", ["", "drop=0.002,flip=0.001,noise=0.002,stall=0.3@2"])
@pytest.mark.parametrize(
    "trouble",
    [
        _none, _cut_cable, _cut_wire_to_robot, _silence_camera, _withdraw_permit,
        _freeze_processor, _press_button, _stop_and_pause,
    ],
)  # fmt: skip
def test_an_end_that_is_not_due_has_nothing_to_do(trouble: Trouble, faults: str) -> None:
    assert _run(trouble, faults, always=False) == _run(trouble, faults, always=True)
