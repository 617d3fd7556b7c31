"""The doctor: every illness that it knows is found, with a cure, and a bundle tells no secret."""

from __future__ import annotations

import json
import os
import pty
import zipfile
from collections.abc import Iterator
from datetime import datetime
from importlib import metadata
from pathlib import Path

import pytest

from navigation.config.secrecy.secret_places import without_secrets
from navigation.config.secrecy.secrets import HIDDEN
from navigation.machine import doctor
from navigation.machine.doctor import Finding, worst
from tests.support.pictures import call
from tests.support.runs.recordings import make_recording

CONFIGS = Path(__file__).parents[3] / "configs"


def assert_ill(finding: Finding, status: str, words: str) -> None:
    """The finding has that status, says these words, and offers a cure."""
    assert finding.status == status
    assert words in finding.sentence
    assert finding.cure


def test_the_worst_finding_decides() -> None:
    ok, warn, fail = (Finding(status, "a", "b") for status in ("ok", "warn", "fail"))
    assert worst([]) == "ok"
    assert worst([ok, warn]) == "warn"
    assert worst([fail, ok, warn]) == "fail"


def test_an_old_python_is_told() -> None:
    assert_ill(doctor.check_python((3, 10)), "fail", "3.10")
    assert doctor.check_python((3, 13)).status == "ok"


def test_packages_that_are_old_or_missing_are_told_one_by_one() -> None:
    there = {"numpy": "1.25.9", "click": "8.1.0", "rich": "13"}

    def installed(name: str) -> str:
        if name not in there:
            raise metadata.PackageNotFoundError(name)
        return there[name]

    wanted = ["numpy>=1.26", "click>=8.1", "rich>=13.0", "cobs>=1.2", "scipy>=1; extra == 'dev'"]
    found = list(doctor.check_packages(wanted, installed))
    assert_ill(found[0], "fail", "numpy 1.25.9: must be >= 1.26")
    assert_ill(found[1], "fail", "cobs is missing")
    assert (found[2].status, found[2].sentence) == ("ok", "click 8.1.0, rich 13")


def test_release_candidates_and_long_versions_are_compared_by_their_numbers() -> None:
    versions = {"a": "2.0.0rc1", "b": "5.0.0.93", "c": "1.10"}
    found = list(doctor.check_packages(["a>=2", "b>=4.10", "c>=1.9"], versions.__getitem__))
    assert [finding.status for finding in found] == ["ok"]


def test_two_opencvs_are_told() -> None:
    twice = doctor.check_opencv_twice(["opencv-python", "opencv-contrib-python-headless", "numpy"])
    assert twice is not None
    assert_ill(twice, "fail", "overwrite each other")
    assert doctor.check_opencv_twice(["opencv-contrib-python-headless"]) is None


@pytest.mark.parametrize(
    ("free_mb", "status"), [(50_000.0, "ok"), (1_000.0, "warn"), (100.0, "fail")]
)
def test_a_full_disk_is_told(tmp_path: Path, free_mb: float, status: str) -> None:
    finding = doctor.check_disk(tmp_path / "not" / "yet", lambda _: int(free_mb * 1e6))
    assert finding.status == status
    assert str(tmp_path) in finding.sentence


def test_a_clock_in_the_past_and_one_that_follows_nobody_are_told() -> None:
    assert_ill(doctor.check_clock(datetime(1970, 1, 1), None), "warn", "in the past")
    assert_ill(doctor.check_clock(datetime(2030, 1, 1), False), "warn", "not synchronised")
    assert doctor.check_clock(datetime(2030, 1, 1), True).status == "ok"


def test_one_core_is_little() -> None:
    assert_ill(doctor.check_cores(1), "warn", "1 core")
    assert doctor.check_cores(4).status == "ok"


def test_threads_that_are_woken_late_are_said_with_the_load() -> None:
    late = doctor.check_wakeups(0.25, 9.06)
    assert_ill(late, "warn", "woken at most 250 ms late, load 9.1")
    assert doctor.check_wakeups(0.003, 0.4).status == "ok"


def test_a_folder_that_is_a_file_or_forbidden_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    assert_ill(doctor.check_writable("runs", tmp_path / "file" / "runs"), "fail", "no folder")
    assert doctor.check_writable("runs", tmp_path / "new" / "runs").status == "ok"
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert_ill(doctor.check_writable("runs", tmp_path), "fail", "cannot be written to")


@pytest.fixture
def terminal() -> Iterator[Path]:
    ours, theirs = pty.openpty()
    yield Path(os.ttyname(theirs))
    os.close(ours)
    os.close(theirs)


def test_a_port_is_there_missing_no_device_or_forbidden(
    tmp_path: Path, terminal: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def look(path: Path, groups: list[str]) -> Finding:
        return doctor.check_device("serial port", path, "dialout", groups)

    assert look(terminal, []).status == "ok"
    assert_ill(look(tmp_path / "ttyUSB0", []), "fail", "No such file")
    (tmp_path / "file").write_text("")
    assert_ill(look(tmp_path / "file", []), "fail", "no device")
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert "usermod -aG dialout" in look(terminal, []).cure
    assert "log out and in" in look(terminal, ["dialout"]).cure


@pytest.mark.parametrize("name", ["ModemManager", "brltty"])
def test_a_program_that_takes_serial_ports_is_named(name: str, tmp_path: Path) -> None:
    (tmp_path / "17").mkdir()
    (tmp_path / "17" / "comm").write_text(f"{name}\n")
    (found,) = doctor.check_port_takers(doctor.running_programs(tmp_path))
    assert_ill(found, "warn", name)
    assert not list(doctor.check_port_takers(["python"]))


def test_kernels_that_are_not_compiled_are_a_warning() -> None:
    assert_ill(doctor.check_kernels(True, None, {}), "warn", "not compiled")
    assert doctor.check_kernels(False, None, {"NUMBA_CACHE_DIR": "/k"}).sentence.endswith("/k")


# The command.


def test_a_machine_that_can_do_the_simulated_run_is_well() -> None:
    told = call("doctor", CONFIGS / "simulation.yaml", "--format", "json")
    assert told.code == 0, told
    body = json.loads(told.out)
    assert body["schema"] == "clearway.doctor/1"
    names = {finding["name"] for finding in body["findings"]}
    assert {"python", "packages", "kernels", "disk", "camera", "serial port", "clock"} <= names
    assert all(finding["cure"] for finding in body["findings"] if finding["status"] != "ok")


def test_a_missing_camera_and_port_fail_with_their_cures(tmp_path: Path) -> None:
    text = (CONFIGS / "simulation.yaml").read_text()
    text = text.replace("source: simulated  ", "source: /dev/video97  ")
    text = text.replace("port: simulated  ", "port: /dev/ttyUSB97  ")
    text = text.replace(
        "  calibration: simulation_calibration.yaml\n", "  metres_per_pixel: 0.002\n"
    )
    text = text.replace("marker_height_m: 0.12  ", "marker_height_m: 0.0  ")
    (tmp_path / "arenas").mkdir()
    arena = (CONFIGS / "arenas" / "laboratory.txt").read_text()
    (tmp_path / "arenas" / "laboratory.txt").write_text(arena)
    (tmp_path / "real.yaml").write_text(text)
    told = call("doctor", tmp_path / "real.yaml")
    assert told.code == 1
    assert "/dev/video97: No such file" in told.out
    assert "/dev/ttyUSB97: No such file" in told.out
    assert "clearway devices" in told.out


def test_what_is_plugged_in_and_may_not_be_opened_is_a_warning(
    terminal: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Found on a PC whose user was in none of the groups: everything was well."""
    plugged_in = [{"path": str(terminal), "device": str(terminal), "name": "a camera"}]
    monkeypatch.setattr("navigation.cli.setup.devices.cameras_here", lambda: plugged_in)
    monkeypatch.setattr("navigation.cli.setup.devices.serial_ports", list)

    def cameras() -> list[list[str]]:
        found = json.loads(call("doctor", "--format", "json").out)["findings"]
        return [[f["status"], f["sentence"]] for f in found if f["name"] == "cameras"]

    assert cameras() == [["ok", str(terminal)]]
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: path != terminal and access(path, mode))
    assert cameras()[1:] == [["warn", f"{terminal}: no permission"]]


def test_a_broken_configuration_is_a_finding_among_others(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("arena: 1\n")
    told = call("doctor", tmp_path / "a.yaml")
    assert told.code == 1
    assert "must be a section of its own" in told.out
    assert "python" in told.out


# The bundle.


def test_a_bundle_holds_configuration_versions_last_run_and_the_recording_s_head(
    tmp_path: Path,
) -> None:
    make_recording(tmp_path / "recordings", lambda bench: bench.frames(3))
    run = tmp_path / "runs" / "2026-01-01_00-00-00"
    run.mkdir(parents=True)
    (run / "report.json").write_text('{"state": "done"}')
    (run / "events.jsonl").write_text('{"event": "ready"}\n')
    text = (CONFIGS / "simulation.yaml").read_text()
    text = text.replace(
        "runs_dir: runs", f"runs_dir: {tmp_path}/runs\n  folder: {tmp_path}/recordings"
    )
    text = text.replace("simulation_calibration", f"{CONFIGS}/simulation_calibration")
    text = text.replace("arenas/laboratory", f"{CONFIGS}/arenas/laboratory")
    (tmp_path / "a.yaml").write_text(text)
    told = call("doctor", tmp_path / "a.yaml", "--bundle", tmp_path / "report.zip")
    assert told.code == 0, told
    with zipfile.ZipFile(tmp_path / "report.zip") as archive:
        names = set(archive.namelist())
        versions = json.loads(archive.read("versions.json"))
        assert archive.read("last_run/report.json") == b'{"state": "done"}'
    assert {
        "findings.json",
        "versions.json",
        "configuration.yaml",
        "calibration.yaml",
        "arena.txt",
        "last_run/events.jsonl",
    } <= names
    assert any(name.startswith("recording/clearway_") for name in names)
    assert "numpy" in versions["packages"]


def test_a_bundle_of_a_broken_configuration_holds_its_text(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("arena: 1\ndashboard:\n  token: hunter2\n")
    call("doctor", tmp_path / "a.yaml", "--bundle", tmp_path / "report.zip")
    with zipfile.ZipFile(tmp_path / "report.zip") as archive:
        text = archive.read("configuration.yaml").decode()
    assert "arena: 1" in text
    assert "hunter2" not in text


@pytest.mark.parametrize(
    ("line", "hidden"),
    [
        ("  token: hunter2\n", f"  token: {HIDDEN}\n"),
        ('"api_key": "hunter2",\n', f'"api_key": {HIDDEN}\n'),
        ("password : x y\n", f"password : {HIDDEN}\n"),
        ("source: rtsp://me:hunter2@camera/1\n", f"source: rtsp://{HIDDEN}@camera/1\n"),
        ("marker_id: 7\n", "marker_id: 7\n"),
        ("token:\n", "token:\n"),
    ],
)
def test_secrets_are_left_out(line: str, hidden: str) -> None:
    assert without_secrets(line) == hidden
