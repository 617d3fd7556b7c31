"""Whose a kept mission is, and who may open its file."""

import os
import stat
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from navigation.journal.journal import Journal, JournalError, owner_of
from navigation.journal.journal_file import JournalFile
from tests.navigation.journal.kept import DRIVING, OWNER, PLAN, aside, keep
from tests.support.runs.virtual import short_config

# Whose it is.


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"robot": "8 of DICT_4X4_50"}, "the robot 7 of DICT_4X4_50, not 8 of DICT_4X4_50"),
        ({"port": "/dev/ttyUSB1"}, "the port simulated, not /dev/ttyUSB1"),
        ({"bounds_m": (0.0, 0.0, 1.0, 1.0)}, "the arena [-1000.0"),
        ({"configuration": "/etc/b.yaml"}, "the configuration /etc/a.yaml, not /etc/b.yaml"),
        ({"camera": "b"}, "another camera"),
    ],
)
def test_a_mission_of_another_robot_arena_or_configuration_is_never_driven(
    path: Path, other: dict[str, Any], words: str
) -> None:
    keep(path)
    with Journal(path, replace(OWNER, **other)) as journal:
        assert journal.unfinished() is None
        assert journal.plan() is None
        assert words in journal.remark
        assert "journal.other-1" in journal.remark
        assert "\n" not in journal.remark
    with Journal(path.with_name("journal.other-1"), OWNER) as journal:
        assert journal.unfinished() == DRIVING


def test_the_owner_follows_from_the_configuration_and_holds_no_password() -> None:
    config = short_config([])
    address = "rtsp://me:geheim-4711@host/live"
    seen = config.model_copy(
        update={"camera": config.camera.model_copy(update={"source": address})}
    )
    assert owner_of(config) != owner_of(seen)
    assert "geheim" not in str(owner_of(seen, Path("a.yaml")))
    assert owner_of(config, Path("a.yaml")) != owner_of(config, Path("b.yaml"))
    assert owner_of(config, Path("a.yaml")) == owner_of(short_config([]), Path("a.yaml"))


# Locks and rights.


def test_a_second_program_is_refused(path: Path) -> None:
    second = (
        "import sys\nfrom pathlib import Path\n"
        "from navigation.journal.journal import *\n"
        "try:\n    Journal(Path(sys.argv[1]), Owner())\n"
        "except JournalError as error:\n    print(error)\n"
    )
    with Journal(path, OWNER) as journal:
        journal.keep(DRIVING, PLAN, 0.0)
        told = subprocess.run(
            [sys.executable, "-c", second, str(path)], capture_output=True, text=True, check=True
        ).stdout
        assert f"journal {path}: is in use by another program" in told
        assert aside(path) == ["journal"]


def test_a_journal_is_locked_against_every_name_of_it(path: Path) -> None:
    keep(path)
    link = path.with_name("link")
    link.symlink_to(path)
    with Journal(link, OWNER) as journal:
        journal.keep(DRIVING.with_visited(2), PLAN, 0.0)
        with pytest.raises(JournalError, match="in use by another program"):
            JournalFile(path, OWNER, patience_s=0.0)
    assert link.is_symlink()
    with Journal(path, OWNER) as journal:
        assert journal.mission() == DRIVING.with_visited(2)


def test_a_journal_whose_lock_was_deleted_is_not_written_by_two_programs(path: Path) -> None:
    with Journal(path, OWNER) as journal:
        journal.keep(DRIVING, PLAN, 0.0)
        path.with_name(".journal.lock").unlink()
        with Journal(path, OWNER) as second:
            for now_s in (0.0, 2.0):
                journal.keep(DRIVING.with_visited(2), None, now_s)
                assert journal.trouble
            assert "in use by another program" in journal.trouble
            assert second.mission() == DRIVING
        with Journal(path, OWNER) as second:
            assert second.mission() == DRIVING


@pytest.mark.parametrize("exists", [False, True])
def test_nobody_else_may_read_it(path: Path, exists: bool) -> None:
    before = os.umask(0)
    try:
        if exists:
            keep(path)
            path.chmod(0o666)
        with Journal(path, OWNER) as journal:
            journal.keep(DRIVING.with_visited(2), PLAN, 0.0)
            found = {f.name: stat.S_IMODE(f.stat().st_mode) for f in path.parent.iterdir()}
    finally:
        os.umask(before)
    assert {"journal", ".journal.lock"} <= found.keys()
    assert set(found.values()) == {0o600}, found


def test_what_is_no_ordinary_file_is_refused(path: Path) -> None:
    path.mkdir()
    with pytest.raises(JournalError, match="no ordinary file"):
        Journal(path, OWNER)
    os.mkfifo(path.with_name("pipe"))
    with pytest.raises(JournalError, match="no ordinary file"):
        Journal(path.with_name("pipe"), OWNER)
