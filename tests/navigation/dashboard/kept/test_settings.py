"""The configuration on the page: what is told, what is refused, what is saved and taken back."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from navigation.cli.setup.check import file_problems
from navigation.config import Config
from navigation.config.load import load_config
from navigation.config.marks import Location
from navigation.dashboard.settings import desk
from navigation.dashboard.settings.desk import Around, Desk
from navigation.dashboard.visits import RefusedError
from navigation.mission.mission import State
from navigation.shared.outside import REPLACEMENT
from tests.navigation.dashboard.site import KEY, TOKEN, VIEWER, Site
from tests.support.runs.shown import FakeDaemon, laboratory, shown_config

CONFIGS = Path(__file__).parents[4] / "configs"
SECRET = "a-secret-of-some-length"


class Office:
    """A desk over a copy of a shipped configuration, and how often it asked for a reload."""

    def __init__(self, folder: Path, name: str = "simulation.yaml") -> None:
        shutil.copytree(CONFIGS, folder / "etc")
        self.file = folder / "etc" / name
        self.file.write_text(f"{self.file.read_text()}\ndashboard:\n  token: {SECRET}\n")
        self.reloads = 0
        self.state = folder / "state"
        self.desk = self.made(file_problems)

    def made(self, problems: Callable[[Config], Iterable[tuple[Location, str]]]) -> Desk:
        return Desk(
            Around(
                file=self.file,
                state=self.state,
                environment={},
                file_problems=problems,
                devices=lambda: (["/dev/v4l/by-id/usb-a"], ["/dev/serial/by-id/usb-b"]),
                reload=self._reload,
            )
        )

    def _reload(self) -> None:
        self.reloads += 1

    @property
    def base(self) -> str:
        return str(self.desk.show()["base"])

    def fields(self) -> dict[str, dict[str, Any]]:
        sections = self.desk.show()["sections"]
        return {key["key"]: key for section in sections for key in section["keys"]}


@pytest.fixture
def office(tmp_path: Path) -> Office:
    return Office(tmp_path)


@pytest.fixture
def open_page(office: Office) -> Iterator[Site]:
    with Site(FakeDaemon(roadmap=laboratory()), office.desk) as site:
        yield site


def post(site: Site, address: str, token: str = "", **body: object) -> tuple[int, Any]:
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    code, text, _ = site.get(address, "POST", json.dumps(body).encode(), **headers)
    return code, json.loads(text) if code == 200 else text


# The desk.


def test_every_key_is_told_with_what_it_is_and_secrets_are_not(office: Office) -> None:
    fields = office.fields()
    assert fields["camera.rate_hz"]["value"] == "30"
    assert fields["camera.rate_hz"]["limits"] == {"above": 0, "most": 1000}
    assert fields["arena.bounds_m"]["value"] == "0, 0, 2.4, 1.8"
    assert fields["planning.margin"]["choices"] == ["relaxed", "strict"]
    assert fields["camera.source"]["choices"] == ["simulated", "/dev/v4l/by-id/usb-a"]
    assert fields["serial.port"]["choices"] == ["simulated", "/dev/serial/by-id/usb-b"]
    assert SECRET not in json.dumps(office.desk.show())
    assert fields["dashboard.token"]["value"] == "(not shown)"


@pytest.mark.parametrize(
    "key",
    [
        "dashboard.token", "dashboard.host", "safety.lease_s", "simulation.robot.faults",
        "recording.runs_dir", "camera.calibration", "mission.stations", "nothing.at_all",
    ],
)  # fmt: skip
def test_what_the_page_may_not_change_is_refused(office: Office, key: str) -> None:
    before = office.file.read_text()
    (problem,) = office.desk.check({key: "1"})
    assert problem["key"] == key
    with pytest.raises(RefusedError, match=key.replace(".", r"\.")):
        office.desk.save({key: "1"}, office.base)
    assert office.file.read_text() == before
    assert office.reloads == 0


@pytest.mark.parametrize(
    ("key", "typed", "words"),
    [
        ("camera.rate_hz", "fast", "must be a number"),
        ("camera.rate_hz", "-3", "> 0"),
        ("planning.margin", "lax", "must be one of relaxed, strict, not lax"),
        ("planning.margin", "lax\nlax", f"strict, not lax{REPLACEMENT}lax"),
        ("camera.source", "/etc/passwd", "must be one of simulated, /dev/v4l/by-id/usb-a"),
        ("serial.port", "socket://example.org:80", "must be one of simulated"),
        ("arena.bounds_m", "0, 0, 2.4", "arena.bounds_m[3]: is missing"),
        ("camera.gain", "{a: 1}", "is no value"),
        ("camera.gain", "1\nserial: {port: /dev/x}", "is no value"),
        ("camera.gain", "x" * 501, "more than 500 characters"),
        ("robot.radius_m", "", "missing"),
    ],
)
def test_what_is_wrong_is_said_at_its_key(office: Office, key: str, typed: str, words: str) -> None:
    problems = office.desk.check({key: typed})
    assert any(words in one["sentence"] and one["key"] == key for one in problems), problems


def test_a_save_changes_the_keys_and_nothing_else(office: Office) -> None:
    before = office.file.read_text()
    said = office.desk.save({"camera.rate_hz": "25", "planning.margin": "strict"}, office.base)
    assert said == "saved camera.rate_hz, planning.margin in simulation.yaml"
    assert office.reloads == 1
    config = load_config(office.file, {})
    assert (config.camera.rate_hz, config.planning.margin) == (25.0, "strict")
    gone = set(before.splitlines()) - set(office.file.read_text().splitlines())
    assert gone == {"  rate_hz: 30"}


def test_an_emptied_field_has_its_default(office: Office) -> None:
    office.desk.save({"camera.rate_hz": " "}, office.base)
    assert "rate_hz: 30\n" not in office.file.read_text().split("simulation:")[0]
    assert load_config(office.file, {}).camera.rate_hz == 30.0


def test_the_last_save_is_undone_and_the_one_before(office: Office) -> None:
    first = office.file.read_text()
    office.desk.save({"camera.rate_hz": "25"}, office.base)
    second = office.file.read_text()
    office.desk.save({"camera.rate_hz": "20"}, office.base)
    office.desk.undo()
    assert office.file.read_text() == second
    office.desk.undo()
    assert office.file.read_text() == first
    assert office.reloads == 4
    with pytest.raises(RefusedError, match="no earlier text"):
        office.desk.undo()


def test_a_file_that_somebody_else_has_changed_is_not_written_over(office: Office) -> None:
    base = office.base
    office.file.write_text(office.file.read_text() + "# mine\n")
    with pytest.raises(RefusedError, match="changed by someone else"):
        office.desk.save({"camera.rate_hz": "25"}, base)
    assert office.file.read_text().endswith("# mine\n")


def test_an_undo_puts_no_earlier_text_over_what_somebody_else_has_changed(office: Office) -> None:
    first = office.file.read_text()
    office.desk.save({"camera.rate_hz": "25"}, office.base)
    saved = office.file.read_text()
    changed = saved.replace("simulation_calibration.yaml", "other_calibration.yaml") + (
        "safety: {lease_s: 0.3}\nrecording: {runs_dir: elsewhere}\n"
    )
    office.file.write_text(changed)
    assert office.desk.show()["earlier"] == 0
    with pytest.raises(RefusedError, match="changed by someone else since"):
        office.desk.undo()
    assert office.file.read_text() == changed
    assert office.reloads == 1
    office.file.write_text(saved)
    assert office.desk.show()["earlier"] == 1
    office.desk.undo()
    assert office.file.read_text() == first


def test_a_file_keeps_its_mode_its_line_ends_and_the_link_to_it(office: Office) -> None:
    """A mode of 0600 became 0644, with the token in it; a link became a file."""
    text = office.file.read_text()
    real = office.file.with_name("real.yaml")
    real.write_bytes(text.replace("\n", "\r\n").encode())
    real.chmod(0o600)
    before = real.read_bytes()
    office.file.unlink()
    office.file.symlink_to(real.name)
    office.desk.save({"camera.rate_hz": "25"}, office.base)
    assert office.file.is_symlink()
    assert real.stat().st_mode & 0o777 == 0o600
    saved = real.read_bytes()
    assert set(before.split(b"\r\n")) - set(saved.split(b"\r\n")) == {b"  rate_hz: 30"}
    assert saved.count(b"\n") == saved.count(b"\r\n")
    office.desk.undo()
    assert real.read_bytes() == before


def test_a_file_that_may_not_be_written_is_left_as_it_is(
    office: Office, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The name was given to a new file, which its folder allows."""
    office.desk.save({"camera.rate_hz": "25"}, office.base)
    before = office.file.read_text()
    with monkeypatch.context() as read_only:
        read_only.setattr(os, "access", lambda *_file, **_how: False)
        with pytest.raises(RefusedError, match="cannot be written: Permission denied"):
            office.desk.save({"camera.rate_hz": "20"}, office.base)
    assert office.file.read_text() == before
    assert office.desk.show()["earlier"] == 1, "the save before can be undone"
    office.desk.undo()
    assert load_config(office.file, {}).camera.rate_hz == 30.0


def test_a_change_of_somebody_else_while_a_save_is_checked_is_not_written_over(
    office: Office,
) -> None:
    base, text = office.base, office.file.read_text()

    def edited_meanwhile(_config: Config) -> Iterator[Any]:
        office.file.write_text(text + "# mine\n")
        yield from ()

    office.desk = office.made(edited_meanwhile)
    with pytest.raises(RefusedError, match="changed by someone else since: read it again first"):
        office.desk.save({"camera.rate_hz": "25"}, base)
    assert office.file.read_text() == text + "# mine\n"
    assert office.reloads == 0
    assert office.desk.show()["earlier"] == 0


def test_a_text_kept_by_an_earlier_version_is_not_put_back_but_counted(office: Office) -> None:
    before = office.file.read_text()
    office.desk.save({"camera.rate_hz": "25"}, office.base)
    (kept,) = office.state.rglob("*.yaml")
    kept.rename(kept.with_name("000007.yaml"))
    with pytest.raises(RefusedError, match="changed by someone else since"):
        office.desk.undo()
    second = office.file.read_text()
    office.desk.save({"camera.rate_hz": "20"}, office.base)
    office.desk.undo()
    assert office.file.read_text() == second != before


def test_no_key_that_takes_a_file_an_address_or_a_command_can_be_changed(office: Office) -> None:
    """The words of each changeable text are few: `/etc/passwd` is refused in every one."""
    changeable = {name for name, one in office.fields().items() if not one["only_shown"]}
    assert len(changeable) > 50
    for typed in ("/etc/passwd", "../../etc/passwd", "http://127.0.0.1:1/x", "[/etc/passwd]"):
        problems = office.desk.check(dict.fromkeys(changeable, typed))
        assert changeable <= {one["key"] for one in problems}, typed


def test_earlier_texts_are_private_and_few(office: Office, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(desk, "MOST_KEPT", 3)
    for rate in range(3 + 2):
        office.desk.save({"camera.rate_hz": str(10 + rate)}, office.base)
    kept = sorted(office.state.rglob("*.yaml"))
    assert len(kept) == 3
    assert {file.stat().st_mode & 0o777 for file in kept} == {0o600}


def test_what_clearway_check_would_refuse_is_refused(office: Office) -> None:
    (office.file.parent / "simulation_calibration.yaml").unlink()
    problems = office.desk.check({"camera.rate_hz": "25"})
    assert [one["key"] for one in problems] == ["camera.calibration"]


# The addresses.


def test_settings_are_read_checked_and_saved_over_the_page(open_page: Site, office: Office) -> None:
    code, text, _ = open_page.get("/api/settings")
    assert code == 200
    base = json.loads(text)["base"]
    changes = {"camera.rate_hz": "25"}
    assert post(open_page, "/api/settings/check", changes=changes) == (
        200,
        {"ok": True, "problems": []},
    )
    _, told = post(open_page, "/api/settings/save", changes=changes, base=base, key=KEY)
    assert told == {"ok": False, "error": "take control first"}
    with open_page.live() as page:
        page.join(name="Ada")
        page.send(type="take", id=1)
        assert page.hear("answer")["ok"]
        _, told = post(open_page, "/api/settings/save", changes=changes, base=base, key=KEY)
        assert told["ok"], told
        assert load_config(office.file, {}).camera.rate_hz == 25.0
        _, told = post(open_page, "/api/settings/undo", key=KEY)
        assert told["ok"], told
    assert office.reloads == 2
    assert open_page.dashboard.hub is not None
    last = open_page.dashboard.hub.chronicle.log.last
    assert last is not None


@pytest.mark.parametrize(
    "state", [one for one in State if one not in (State.IDLE, State.DONE, State.FAILED)]
)
def test_nothing_is_saved_while_a_mission_is_under_way_or_the_robot_is_stopped(
    open_page: Site, office: Office, state: State
) -> None:
    daemon = open_page.daemon
    daemon.people.describe = lambda: {"state": state.value}  # type: ignore[method-assign]
    with open_page.live() as page:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        for address in ("save", "undo"):
            _, told = post(
                open_page, f"/api/settings/{address}",
                changes={"camera.rate_hz": "25"}, base=office.base, key=KEY,
            )  # fmt: skip
            assert not told["ok"]
            assert "no mission is under way" in told["error"]
    assert office.reloads == 0


@pytest.mark.parametrize("token", ["", VIEWER, "wrong-token-of-length"])
def test_settings_are_for_operators(office: Office, token: str) -> None:
    with Site(FakeDaemon(shown_config(token=TOKEN, viewer_token=VIEWER)), office.desk) as site:
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        code, text, _ = site.get("/api/settings", **headers)
        assert code in (401, 403), text
        for address in ("check", "save", "undo"):
            assert post(site, f"/api/settings/{address}", token, changes={})[0] in (401, 403)
    assert office.reloads == 0


@pytest.mark.parametrize(
    ("body", "code"),
    [(b"[]", 400), (b"\xff", 400), (b"{" * 100_000, 413), (b'{"changes": 3}', 200)],
)
def test_strange_bodies_are_refused(open_page: Site, body: bytes, code: int) -> None:
    got, text, _ = open_page.get("/api/settings/check", "POST", body)
    assert got == code
    assert code != 200 or not json.loads(text)["ok"]


def test_a_run_without_a_file_has_no_settings(quiet_site: Site) -> None:
    assert quiet_site.get("/api/settings")[0] == 404
