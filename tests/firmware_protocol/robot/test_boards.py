"""The boards' files on stand-ins for their libraries: wiring, signs, and that they are short.

The stand-ins know of each library what its documentation says of the calls that are used. No board
was at hand.
"""

from __future__ import annotations

import importlib
import json
import re
import select
import sys
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

import firmware_protocol.robot as package

FOLDER = Path(package.__file__).parent
BOARDS = sorted(file.stem for file in (FOLDER / "boards").glob("*.py"))
STAND_INS = Path(__file__).parent / "stand_ins"


class Poll:
    """Nobody writes."""

    def register(self, stream: object, events: int) -> None:
        """Stands in for that of ``select``."""

    def ipoll(self, timeout: int) -> list[int]:
        """Stands in for MicroPython's."""
        return []


@pytest.fixture
def board(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A board's file as the board imports it."""
    for folder in (STAND_INS, FOLDER, FOLDER / "boards"):
        monkeypatch.syspath_prepend(str(folder))
    for name in [name for name in sys.modules if name.split(".")[0] == "clearway"]:
        monkeypatch.delitem(sys.modules, name)  # the host's package, which a board has not
    before = set(sys.modules)
    world = importlib.import_module("world")
    monkeypatch.setattr(time, "ticks_us", lambda: world.now_us, raising=False)
    monkeypatch.setattr(time, "ticks_diff", lambda a, b: a - b, raising=False)
    monkeypatch.setattr(select, "poll", Poll)
    module = importlib.import_module(request.param)
    yield module  # type: ignore[misc]
    for name in set(sys.modules) - before:
        del sys.modules[name]


def test_every_board_of_the_documents_has_a_file() -> None:
    assert BOARDS == ["alvik", "esp32", "pico", "pololu_3pi_2040", "xrp"]


@pytest.mark.parametrize("name", BOARDS)
def test_a_boards_file_has_less_than_60_lines(name: str) -> None:
    assert len((FOLDER / "boards" / f"{name}.py").read_text().splitlines()) < 60


@pytest.mark.parametrize("board", BOARDS, indirect=True)
def test_both_wheels_drive_forwards_and_backwards(board: ModuleType) -> None:
    world = importlib.import_module("world")
    one = board.Board()
    world.pass_time()
    one.drive(800, 400, True)
    left, right = world.wheels()
    assert left > right > 0.0
    world.pass_time()
    one.drive(-400, 800, True)
    left, right = world.wheels()
    assert left < 0.0 < right
    one.drive(0, 0, False)  # at once
    assert world.wheels() == (0.0, 0.0)


@pytest.mark.parametrize("board", BOARDS, indirect=True)
def test_speed_is_what_was_asked_for(board: ModuleType) -> None:
    """Of a hundred orders, because a driver's steps may be coarse."""
    world = importlib.import_module("world")
    one, sums = board.Board(), [0.0, 0.0]
    for _ in range(100):
        world.pass_time()
        one.drive(400, -200, True)
        sums = [total + speed for total, speed in zip(sums, world.wheels(), strict=True)]
    assert sums[0] / 100 == pytest.approx(50.0, rel=0.05)
    assert sums[1] / 100 == pytest.approx(-25.0, rel=0.05)


@pytest.mark.parametrize("board", BOARDS, indirect=True)
def test_travel_is_what_the_wheels_did(board: ModuleType) -> None:
    world = importlib.import_module("world")
    one = board.Board()
    for side in (0, 1):
        one.travel_um(side)
    total = [0, 0]
    for _ in range(20):
        world.turn(5.0, -2.5)
        for side in (0, 1):
            total[side] += one.travel_um(side)
    assert total[0] == pytest.approx(100_000, rel=0.02)
    assert total[1] == pytest.approx(-50_000, rel=0.02)


@pytest.mark.parametrize("board", BOARDS, indirect=True)
def test_the_button_is_seen(board: ModuleType) -> None:
    world = importlib.import_module("world")
    one = board.Board()
    assert not one.stop_pressed()
    world.press()
    assert one.stop_pressed()
    one.idle(True)
    one.idle(False)


def _held(board: ModuleType) -> Callable[[], bool]:
    """What the board's file asks for its boot button."""
    (name,) = [name for name in vars(board) if name.endswith("_held")]
    held: Callable[[], bool] = getattr(board, name)
    return held


@pytest.mark.parametrize("board", BOARDS, indirect=True)
def test_a_button_held_at_boot_leads_to_the_repl(
    board: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    world, start = importlib.import_module("world"), importlib.import_module("clearway.start")
    slept: list[int] = []
    monkeypatch.setattr(time, "sleep_ms", slept.append, raising=False)
    assert start.may_start(_held(board))
    assert sum(slept) == start.WINDOW_MS
    world.held_at_boot = True
    assert not start.may_start(_held(board))
    assert sum(slept) == start.WINDOW_MS, "at once"


@pytest.mark.parametrize("board", BOARDS, indirect=True)
def test_ctrl_c_before_the_start_leads_to_the_repl(
    board: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(time, "sleep_ms", interrupted, raising=False)
    start = importlib.import_module("clearway.start")
    with pytest.raises(KeyboardInterrupt):
        start.may_start(_held(board))


@pytest.mark.parametrize("name", BOARDS)
def test_a_board_asks_before_it_takes_the_line_or_starts_a_watchdog(name: str) -> None:
    source = (FOLDER / "boards" / f"{name}.py").read_text()
    head, main = re.split(r'if __name__ == "__main__" and may_start\(\w+_held\):\n', source)
    assert main.strip().startswith("Program(Board(),")
    assert not re.search(r"^\S.*(Board\(\)|WDT\(|UsbLine\(\))", head, re.MULTILINE)


def test_mip_gets_every_file_of_the_package_and_no_other() -> None:
    package = json.loads((FOLDER / "package.json").read_text())
    project = tomllib.loads((FOLDER.parents[1] / "pyproject.toml").read_text())["project"]
    assert package["version"] == project["version"]
    here = sorted(f"clearway/{file.name}" for file in (FOLDER / "clearway").glob("*.py"))
    assert package["urls"] == [[name, name] for name in here]
