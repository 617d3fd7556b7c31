"""Orders about zones: over the socket and by the command, what is taken, refused and shown."""

from __future__ import annotations

import json
import math
import socket as socketlib
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml

from navigation.cli.main import run
from navigation.config import parse_config
from navigation.control import ControlError, ControlServer, send_order
from navigation.dashboard.orders import refusal_of
from navigation.journal.kept_zones import KeptZones
from navigation.loop.daemon import Daemon
from navigation.orders.carry_out import carry_out
from navigation.orders.table import ORDERS
from navigation.run.virtual_world import VirtualWorld
from planner.formats import map_files
from tests.navigation.config.test_zones import ALL_KINDS, MASK_YAML, write_mask
from tests.navigation.config.texts import GOOD
from tests.support.people import RecordedPeople

ARENA = GOOD.replace('"C (1,1) 0.2"', '"#@ clearway.scene/1\\n#@ units m\\nC (1,1) 0.2"')
DESK = {"name": "desk", "kind": "keep_out", "circle": [1.0, 1.0, 0.2]}


@pytest.fixture
def daemon() -> Daemon:
    """One that only waits: nothing drives."""
    config = parse_config(ARENA + ALL_KINDS)
    daemon = Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=1)
    daemon.settle = lambda: None  # type: ignore[method-assign]
    return daemon


@pytest.fixture
def socket(daemon: Daemon, tmp_path: Path) -> Iterator[Path]:
    with ControlServer(tmp_path / "run" / "c.sock", daemon.people) as server:
        yield server.path


def names(answer: dict[str, Any]) -> list[str]:
    return [one["name"] for one in answer["zones"]]


def test_zones_are_put_removed_taken_back_and_listed_over_the_socket(
    socket: Path, daemon: Daemon
) -> None:
    answer = send_order(socket, {"order": "zone_put", "zone": DESK})
    assert answer["zones"][-1] == DESK
    assert answer["changes"] == {"desk": "changed"}
    assert answer["kept"] is False
    assert {"state", "reason", "socket"} <= set(answer)
    assert names(send_order(socket, {"order": "zone_remove", "name": "door"}))[-1] == "desk"
    answer = send_order(socket, {"order": "zone_undo"})
    assert names(answer) == ["bend", "alley", "road", "door", "desk"]
    assert send_order(socket, {"order": "zone_list"})["zones"] == answer["zones"]
    assert daemon.zones.revision == 3


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({"order": "zone_put"}, "zone: must be an object"),
        ({"order": "zone_put", "zone": [DESK]}, "zone: must be an object"),
        ({"order": "zone_put", "zone": {**DESK, "kind": "keep"}}, "zone.kind: must be"),
        ({"order": "zone_put", "zone": {**DESK, "kind": "slow"}}, "needs a speed"),
        ({"order": "zone_put", "zone": {**DESK, "colour": "red"}}, "zone.colour: unknown key"),
        ({"order": "zone_put", "zone": {**DESK, "circle": [1, 1, float("nan")]}}, "zone.circle"),
        ({"order": "zone_put", "zone": {**DESK, "circle": [9, 9, 1]}}, "outside the arena"),
        ({"order": "zone_put", "zone": {**DESK, "robots": ["eve"]}}, "robot 'eve'"),
        (
            {"order": "zone_put", "zone": {"name": "a", "kind": "wait", "mask": "m.yaml"}},
            "absolute path",
        ),
        (
            {"order": "zone_put", "zone": {"name": "a", "kind": "wait", "mask": "/none.yaml"}},
            "zone.mask: this run has no configuration file",
        ),
        ({"order": "zone_remove"}, "name: is missing"),
        ({"order": "zone_remove", "name": 7}, "name: must be a name"),
        ({"order": "zone_remove", "name": "eve"}, "there are desk"),
        ({"order": "zone_undo"}, "no change"),
    ],
)
def test_a_wrong_order_is_refused_in_one_sentence(
    daemon: Daemon, request_: dict[str, Any], words: str
) -> None:
    answer = carry_out(request_, daemon.people)
    assert answer["ok"] is False
    assert words in answer["error"]
    assert "\n" not in answer["error"]
    assert daemon.zones.revision == 0


def put_mask(daemon: Daemon, mask: object) -> dict[str, Any]:
    zone = {"name": "a", "kind": "keep_out", "mask": mask}
    return carry_out({"order": "zone_put", "zone": zone}, daemon.people)


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Each file that is opened for a scene or a mask from now on."""
    files: list[Path] = []
    read_bytes = map_files.read_bytes

    def note(path: Path) -> bytes:
        files.append(path.resolve())
        return read_bytes(path)

    monkeypatch.setattr(map_files, "read_bytes", note)
    return files


def test_an_order_opens_no_file_outside_the_configurations_folder(
    daemon: Daemon, tmp_path: Path, opened: list[Path]
) -> None:
    here, there = tmp_path / "configs", tmp_path / "configs-of-others"
    for folder in (here / "masks", there):
        folder.mkdir(parents=True)
        write_mask(folder)
    daemon.people.masks_in = here
    (here / "link.yaml").symlink_to(there / "mask.yaml")
    (here / "loop.yaml").symlink_to(here / "loop.yaml")
    (here / "picture.yaml").write_text(MASK_YAML.replace("mask.pgm", str(there / "mask.pgm")))
    (here / "above.yaml").write_text(MASK_YAML.replace("mask.pgm", "../mask.pgm"))
    outside = [there / "mask.yaml", here / ".." / there.name / "mask.yaml", here / "link.yaml"]
    outside += [here / "loop.yaml", here / "picture.yaml", here / "above.yaml", tmp_path / "none"]
    for mask in (*map(str, outside), "/etc/passwd\0.yaml"):
        answer = put_mask(daemon, mask)
        assert answer["ok"] is False
        assert answer["error"].startswith("zone.mask = ")
        assert answer["error"].endswith(f"must be in the configuration's folder, {here}")
        assert "\n" not in answer["error"]
    assert all(here in file.parents for file in opened)
    assert daemon.zones.revision == 0
    assert put_mask(daemon, str(here / "masks" / "mask.yaml"))["ok"] is True
    assert daemon.zones.sections[-1].mask == here / "masks" / "mask.yaml"
    assert "none.yaml" in put_mask(daemon, str(here / "none.yaml"))["error"]


def test_changes_are_the_operator_s_and_anybody_may_look() -> None:
    for name in ("zone_put", "zone_remove", "zone_undo"):
        assert refusal_of(name, may_drive=True, holds=False) == "take control first"
        assert refusal_of(name, may_drive=True, holds=True) is None
    assert refusal_of("zone_list", may_drive=False, holds=False) is None


def test_a_list_acts_on_nothing() -> None:
    people = RecordedPeople(zones={"zones": [], "changes": {}, "kept": True})
    assert carry_out({"order": "zone_list"}, people)["zones"] == []
    assert ORDERS["zone_list"].only_looks


def test_zones_of_the_most_corners_fit_into_an_answer(socket: Path, daemon: Daemon) -> None:
    """A client that is slow to read gets what the socket takes at once."""
    begun = len(daemon.zones.sections)
    third = 1.0 / 3.0

    def ring(name: str, corners: int) -> dict[str, object]:
        at = [0.006 * k for k in range(corners)]
        places = [[1.0 + third * math.cos(a), 1.0 + third * math.sin(a)] for a in at]
        return {"name": name, "kind": "keep_out", "polygon": places}

    for name in ("a0", "a1"):
        send_order(socket, {"order": "zone_put", "zone": ring(name, 600)})
    with pytest.raises(ControlError, match="at most 2000"):
        send_order(socket, {"order": "zone_put", "zone": ring("b", 999)})
    send_order(socket, {"order": "zone_put", "zone": ring("b", 790)})
    with slow_client(socket) as client:
        client.sendall(b'{"order": "zone_list"}\n')
        time.sleep(1.0)
        data = b"".join(iter(lambda: client.recv(1 << 16), b""))
    assert len(json.loads(data)["zones"]) == begun + 3


@contextmanager
def slow_client(path: Path) -> Iterator[socketlib.socket]:
    with socketlib.socket(socketlib.AF_UNIX) as client:
        client.settimeout(10.0)
        client.connect(str(path))
        yield client


# The command.


def test_the_command_adds_removes_and_takes_back(
    socket: Path, daemon: Daemon, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ["--socket", str(socket)]
    area = ["--polygon", "0.5,0.5 1,0.5 1,1"]
    assert run(["zone", "add", "shelf", "--kind", "keep_out", *area, *at]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "keep-out zone 'shelf': polygon of 3 corners"
    assert "recording.journal" in said[1]
    band = ["--line", "0,1.5 -0.5,1.5 2,1.5", "--width", "0.3", "--speed", "0.1"]
    assert run(["zone", "add", "lane1", "--kind", "lane", *band, "--cost", "0.3", *at]) == 0
    circle = ["--circle", "-0.1,1,0.3"]
    assert run(["zone", "add", "door", "--kind", "wait", *circle, *at]) == 0
    assert [one.name for one in daemon.zones.sections][-3:] == ["shelf", "lane1", "door"]
    lane = daemon.zones.sections[-2]
    assert (lane.width_m, lane.speed_m_s, lane.cost) == (0.3, 0.1, 0.3)
    assert run(["zone", "remove", "shelf", *at]) == 0
    assert run(["zone", "undo", *at]) == 0
    assert daemon.zones.changes()[-1].name == "lane1"
    assert run(["zone", "remove", "bend", *at, "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["changes"]["bend"] == "removed"


def test_the_list_marks_what_differs_from_the_configuration(
    socket: Path, daemon: Daemon, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ["--socket", str(socket)]
    daemon.people.remove_zone("door")
    for zone in (DESK, {**DESK, "name": "new"}):
        send_order(socket, {"order": "zone_put", "zone": zone})
    assert run(["zone", "list", *at]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.rpartition("(")[2] for line in lines if "while running" in line] == [
        "changed while running)",
        "added while running)",
        "zone 'door' of the configuration: removed while running",
    ]
    assert run(["zone", "list", "--format", "yaml", *at]) == 0
    assert parse_config(GOOD + capsys.readouterr().out).zones == daemon.zones.sections
    assert run(["zone", "list", "--format", "json", *at]) == 0
    assert len(json.loads(capsys.readouterr().out)["zones"]) == 5


def test_the_list_has_a_mask_whose_file_is_gone(
    socket: Path, daemon: Daemon, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mask = write_mask(tmp_path)
    daemon.people.masks_in = tmp_path
    assert put_mask(daemon, str(mask))["ok"]
    mask.unlink()
    for form in ("text", "yaml", "json"):
        assert run(["zone", "list", "--socket", str(socket), "--format", form]) == 0
        assert str(mask) in capsys.readouterr().out


def test_a_file_of_zones_is_added_with_its_masks(
    socket: Path, daemon: Daemon, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_mask(tmp_path)
    daemon.people.masks_in = tmp_path
    file = tmp_path / "zones.yaml"
    listed = [DESK, {"name": "old", "kind": "keep_out", "mask": "mask.yaml"}]
    at = ["--file", str(file), "--socket", str(socket)]
    for written in (listed, {"zones": listed}):
        file.write_text(yaml.safe_dump(written))
        assert run(["zone", "add", *at]) == 0
        assert [one.name for one in daemon.zones.sections][-2:] == ["desk", "old"]
        assert daemon.zones.sections[-1].mask == tmp_path / "mask.yaml"
    capsys.readouterr()
    file.write_text(yaml.safe_dump([DESK, {**DESK, "name": "far", "circle": [9, 9, 1]}]))
    assert run(["zone", "add", *at]) == 2
    assert "outside the arena" in (error := capsys.readouterr().err)
    assert "added before: desk" in error
    daemon.people.masks_in = tmp_path / "configs"
    file.write_text(yaml.safe_dump(listed))
    assert run(["zone", "add", *at]) == 2
    error = capsys.readouterr().err
    assert "must be in the configuration's folder" in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["add", "a"], "needs NAME and --kind"),
        (["add", "a", "--kind", "keep_out"], "no area"),
        (["add", "a", "--kind", "keep_out", "--circle", "1,2"], "must be X,Y,RADIUS"),
        (["add", "a", "--kind", "keep_out", "--polygon", "1,2 nan,1 x"], "must be"),
        (["add", "a", "--kind", "slow", "--circle", "1,2,3"], "needs a speed"),
        (["add", "a", "--kind", "keep_out", "--file", "z.yaml"], "give it alone"),
        (["remove"], "NAME"),
    ],
)
def test_wrong_usage_is_one_sentence_and_code_2(
    arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["zone", *arguments]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("- {name: a, kind: keep_out, circle: [1, 1]}\n", ":1:"),
        ("- {name: a, kind: wait, circle: [1, 1, 1]}\n" * 2, "zones[1].name"),
        ("7\n", "must be a list of zones"),
        ("zones: 7\n", "zones"),
        ("zone: []\n", "did you mean 'zones'"),
        ("- {\n", "zones.yaml"),
        ("[]\n", "must hold one at least"),
    ],
)
def test_a_wrong_file_is_refused_at_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, says: str
) -> None:
    file = tmp_path / "zones.yaml"
    file.write_text(text)
    assert run(["zone", "add", "--file", str(file)]) == 2
    assert says in capsys.readouterr().err


def test_a_change_that_a_restart_would_not_know_says_so(
    socket: Path, daemon: Daemon, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    daemon.zones.restore(KeptZones(tmp_path / "kept" / "zones"))
    (tmp_path / "kept").write_text("in the way")
    at = ["--socket", str(socket)]
    assert run(["zone", "remove", "door", *at]) == 0
    assert "a restart would not know of this change" in capsys.readouterr().out
    (tmp_path / "kept").unlink()
    assert run(["zone", "undo", *at]) == 0
    assert "restart" not in capsys.readouterr().out


def test_without_a_daemon_the_error_says_how_to_start_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["zone", "list", "--socket", str(tmp_path / "none")]) == 2
    assert "clearway run CONFIG" in capsys.readouterr().err


def test_the_daemon_s_refusal_is_said(socket: Path) -> None:
    with pytest.raises(ControlError, match="refuses: zone 'eve'"):
        send_order(socket, {"order": "zone_remove", "name": "eve"})
