"""``calibrate --live`` with a simulated board in virtual time: terminal, lines, page, Ctrl-C."""

from __future__ import annotations

import io
import json
import urllib.error
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from rich.console import Console

from navigation.cli.calibrating import command, live
from navigation.cli.calibrating.page import LivePage
from navigation.cli.calibrating.terminal import TerminalLines, drawn
from navigation.cli.main import run
from tests.support.runs.held_board import VirtualTime, small_config, states
from vision.calibrate.live.session import LiveState
from vision.calibration.calibration_file import load_lens
from vision.camera.camera import Frame

BOARD = ["--squares", "8x6", "--square-mm", "100", "--marker-mm", "75",
         "--dictionary", "DICT_5X5_100"]  # fmt: skip


@pytest.fixture
def virtual(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> VirtualTime:
    """The command's clock is virtual, and its simulated camera small."""
    time = VirtualTime()
    monkeypatch.setattr(command, "time", SimpleNamespace(monotonic=time.clock, sleep=time.wait))
    monkeypatch.setattr(live, "load_config", lambda _: small_config())
    monkeypatch.chdir(tmp_path)
    return time


@pytest.fixture(scope="module")
def seen() -> list[tuple[LiveState, Frame]]:
    """What two views' time shows."""
    return states(26)


def test_a_simulated_hand_does_what_it_is_asked_until_the_lens_is_written(
    virtual: VirtualTime, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ["--live", "simulated.yaml", *BOARD, "--limit-px", "2", "-o", "lens.yaml"]
    assert run(["calibrate", *arguments]) == 0
    said = capsys.readouterr()
    assert "hold the board in the middle of the picture" in said.err
    assert "view 6: taken; 24 of 24 parts" in said.err
    assert "enough views: " in said.err
    assert "px on ones left out" in said.out
    found = load_lens(tmp_path / "lens.yaml")
    assert found.camera_matrix[0, 0] == pytest.approx(617.0, rel=0.01)


@pytest.mark.parametrize(("frames", "views"), [(0, 0), (30, 2)])
def test_ctrl_c_before_three_views_writes_nothing_and_says_so(
    virtual: VirtualTime,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    frames: int,
    views: int,
) -> None:
    interrupt_after(frames, monkeypatch)
    arguments = ["--live", "simulated.yaml", *BOARD, "-o", "lens.yaml"]
    assert run(["calibrate", *arguments]) == 2
    said = capsys.readouterr().err
    assert "ended by Ctrl-C" in said
    assert f"{views} views of the board were taken, at least 3 are needed" in said
    assert not (tmp_path / "lens.yaml").exists()


def test_ctrl_c_with_enough_to_go_on_keeps_what_is_there(
    virtual: VirtualTime, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt_after(85, monkeypatch)
    assert run(["calibrate", "--live", "simulated.yaml", *BOARD, "-o", "lens.yaml"]) == 0
    said = capsys.readouterr()
    assert "ended by Ctrl-C: " in said.err
    assert "written: lens.yaml" in said.out


def interrupt_after(frames: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while the camera is read."""
    read, count = live.HeldBoardCamera.read, [0]

    def interrupted(self: live.HeldBoardCamera, timeout_s: float) -> Frame | None:
        count[0] += 1
        if count[0] > frames:
            raise KeyboardInterrupt
        return read(self, timeout_s)

    monkeypatch.setattr(live.HeldBoardCamera, "read", interrupted)


def test_the_terminal_shows_every_part_and_what_is_wanted(
    seen: list[tuple[LiveState, Frame]],
) -> None:
    for state, _ in seen[::5]:
        console = Console(file=io.StringIO(), width=100, force_terminal=False)
        console.print(drawn(state, "view 1: taken"))
        assert isinstance(console.file, io.StringIO)
        text = console.file.getvalue()
        assert "Hold the board " in text
        assert "spread in px" in text
        assert f"Views: {state.count}; 0 of 24 parts" in text
        assert text.count("?") >= 20


def test_lines_are_written_for_views_only(seen: list[tuple[LiveState, Frame]]) -> None:
    stream = io.StringIO()
    lines = TerminalLines(stream)
    for state, frame in seen:
        lines.show(state, frame)
    taken = sum(state.taken for state, _ in seen)
    assert taken == 2
    assert len(stream.getvalue().splitlines()) == 1 + 2 * taken


def get(url: str, host: str | None = None) -> tuple[int, bytes]:
    request = urllib.request.Request(url, headers={} if host is None else {"Host": host})
    try:
        with urllib.request.urlopen(request, timeout=20.0) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


def test_the_page_shows_the_picture_of_the_state(seen: list[tuple[LiveState, Frame]]) -> None:
    with LivePage(0) as page:
        address = page.url + "api/calibration"
        assert json.loads(get(address)[1]) == {
            "ok": True, "refusal": "", "phase": "taking", "said": "", "state": None, "remarks": [],
        }  # fmt: skip
        assert get(address + "/picture.jpg")[0] == 404
        for state, frame in seen:
            page.show(state, frame)
        told = json.loads(get(address)[1])
        state, frame = seen[-1]
        assert told["state"]["frame"] == frame.sequence
        assert told["state"]["count"] == 2
        assert told["remarks"] == ["view 1: taken", "view 2: taken"]
        assert np.shape(told["state"]["cells"]) == state.cells.done.shape
        code, data = get(address + f"/picture.jpg?frame={seen[-4][1].sequence}")
        assert code == 200
        shown = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)
        assert np.abs(shown.astype(float) - seen[-4][1].image).mean() < 4.0
        for name in ("", "calibrate.js", "calibration.js", "board.css", "palette.css"):
            assert get(page.url + name)[0] == 200
        for name in ("../command.py", "index.html", "live", "api/stop", "api/calibration/start"):
            assert get(page.url + name)[0] == 404
        page.end("enough views")
        told = json.loads(get(address)[1])
        assert (told["phase"], told["said"]) == ("ended", "enough views")


def test_the_page_is_this_machine_s_and_a_port_that_is_taken_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with LivePage(0) as page:
        assert get(page.url + "api/calibration", host="elsewhere.example")[0] == 400
        port = page.url.rsplit(":", 1)[1].strip("/")
        cv2.imwrite("a.png", np.full((64, 64), 128, np.uint8))
        assert run(["calibrate", "--live", "a.png", *BOARD, "--page", port]) == 2
        assert f"--page {port}: " in capsys.readouterr().err
