"""`clearway demo`: a simulated run that opens its own page."""

import threading
import webbrowser

import pytest

from navigation.cli.main import run
from navigation.cli.running.demo import browser_here, opening


def test_the_address_is_said_and_opened_and_other_lines_are_only_said() -> None:
    said: list[str] = []
    opened: list[str] = []
    done = threading.Event()

    def browser(address: str) -> None:
        opened.append(address)
        done.set()

    say = opening(browser, said.append)
    say("camera simulated, robot on /dev/pts/3")
    say("dashboard at http://127.0.0.1:8421/#token=abc")
    assert done.wait(10.0)
    assert opened == ["http://127.0.0.1:8421/#token=abc"]
    assert len(said) == 2


def test_without_a_browser_the_address_is_said_all_the_same() -> None:
    said: list[str] = []
    opening(None, said.append)("dashboard at http://127.0.0.1:8421/")
    assert said == ["dashboard at http://127.0.0.1:8421/"]


@pytest.mark.parametrize("environment", [{}, {"DISPLAY": ":0", "SSH_CONNECTION": "1 2 3 4"}])
def test_no_browser_opens_without_a_screen_or_on_another_machine(
    environment: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    assert browser_here(environment) is None


def test_a_screen_without_a_browser_opens_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> None:
        raise webbrowser.Error("could not locate runnable browser")

    monkeypatch.setattr(webbrowser, "get", none)
    assert browser_here({"DISPLAY": ":0"}) is None


def test_a_demo_drives_its_mission_and_ends(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["demo", "--once", "--no-browser"]) == 0
    out = capsys.readouterr().out
    assert "dashboard at http://127.0.0.1:" in out
    assert "done" in out
