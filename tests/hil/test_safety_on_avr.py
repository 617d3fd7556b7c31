"""The link's safety rows on the AVR binary: it stands in time, and drives again only when told.

The same scenarios run on the Python robot in ``tests/firmware_protocol/test_faults.py``; what
they assert, times included, stands with each of them.
"""

from collections.abc import Iterator

import pytest

from tests.support.robots.avr_firmware import AvrBoard
from tests.support.robots.avr_robot import AvrRobot, missing_tools
from tests.support.wire.fault_scenarios import SCENARIOS, robot_maker

pytestmark = pytest.mark.skipif(missing_tools() is not None, reason=f"needs {missing_tools()}")

ROWS = {
    "lease lapsed": "control loop hangs, poses flow",
    "host silent for long": "silence disarms",
    "host killed": "host killed three times",
    "planner hung, permit withdrawn": "permit withdrawn",
    "pose stale": "camera goes blind",
    "cable pulled": "cable pulled and plugged in",
}


@pytest.fixture(scope="module")
def board() -> Iterator[AvrBoard]:
    with AvrRobot() as build:
        board = AvrBoard(build)
        yield board
        board.close()


@pytest.mark.parametrize("row", ROWS)
def test_the_avr_stands_in_time_and_never_resumes_by_itself(board: AvrBoard, row: str) -> None:
    token = robot_maker.set(board)  # type: ignore[arg-type]
    try:
        assert "executed" in SCENARIOS[ROWS[row]](7)
    finally:
        robot_maker.reset(token)
