"""Stops as files: what they hold, and that nothing but a re-arm ends them."""

from __future__ import annotations

import errno
from datetime import datetime
from pathlib import Path

import pytest

from navigation.journal import kept_stops
from navigation.journal.kept_stops import KeptStops
from navigation.journal.stop_latch import Latch, held_by, read_latches, write_latch
from tests.support.waiting import wait_until

LATCH = Latch("left", "a person", "2026-11-25", "/run/c.sock", "/etc/a.yaml", ("/dev/ttyA",))
FLEET = {"left": ("/dev/ttyA",), "right": ("/dev/ttyB",)}
NOW = datetime(2026, 11, 25)


def kept(folder: Path, **other: object) -> KeptStops:
    given: dict[str, object] = {"socket": Path("/run/c.sock"), "configuration": None}
    return KeptStops(folder, ports={"": ("/dev/ttyA",)}, now=lambda: NOW, **(given | other))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("socket", "configuration", "ports", "held"),
    [
        ("/run/c.sock", "/etc/b.yaml", FLEET, {"left"}),
        ("/run/d.sock", "/etc/a.yaml", FLEET, {"left"}),
        ("/run/d.sock", "/etc/b.yaml", FLEET, {"left"}),
        ("/run/d.sock", "/etc/b.yaml", {"": ("/dev/ttyA",)}, {""}),
        ("/run/c.sock", "/etc/b.yaml", {"": ("/dev/ttyC",)}, {""}),
        ("/run/c.sock", "", {"a": (), "b": ()}, {"a", "b"}),
        ("/run/d.sock", "", {"left": ()}, set()),
    ],
)
def test_a_stop_holds_what_has_its_socket_configuration_or_port(
    tmp_path: Path,
    socket: str,
    configuration: str,
    ports: dict[str, tuple[str, ...]],
    held: set[str],
) -> None:
    write_latch(tmp_path, LATCH)
    (one,) = read_latches(tmp_path)
    assert one.latch == LATCH
    assert held_by(one, socket, configuration, ports) == held


def test_a_stop_that_lost_bytes_or_has_a_bit_flipped_stops_every_robot(tmp_path: Path) -> None:
    file = write_latch(tmp_path, LATCH)
    whole = file.read_bytes()
    harms = [whole[:length] for length in range(len(whole))]
    for place in range(len(whole)):
        flipped = whole[place] ^ (1 << place % 8)
        harms.append(whole[:place] + bytes([flipped]) + whole[place + 1 :])
    for harm in harms:
        file.write_bytes(harm)
        (one,) = read_latches(tmp_path)
        assert held_by(one, "/elsewhere", "", FLEET) == {"left", "right"}
        assert "clearway resume" in one.sentence


def test_a_stop_stays_until_the_re_arm_however_often_the_program_begins(tmp_path: Path) -> None:
    with kept(tmp_path) as first:
        assert first.held == {}
        first.stop([""], "a person")
        assert first.settled() == ""
        assert len(read_latches(tmp_path)) == 1  # before it is answered
    for _ in range(3):
        with kept(tmp_path) as later:
            assert "a person" in later.held[""]
    with kept(tmp_path) as last:
        last.lift([""])
        assert last.settled() == ""
    with kept(tmp_path) as after:
        assert after.held == {}


def test_a_disk_that_fails_or_hangs_delays_no_stop_and_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_given: object) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kept_stops, "write_latch", full)
    with kept(tmp_path) as stops:
        stops.stop([""], "a person")
        assert "No space left on device" in stops.settled()


@pytest.mark.parametrize("order", ["stop", "lift"])
def test_a_disk_that_was_full_is_tried_again_without_another_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, order: str
) -> None:
    """The next run held the robot only if someone happened to stop it once more."""
    monkeypatch.setattr(kept_stops, "RETRY_S", 0.02)
    folder = tmp_path / "stops"
    if order == "lift":
        write_latch(folder, LATCH)
    with kept(folder) as stops, monkeypatch.context() as full:

        def no_space(*_arguments: object) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

        full.setattr(kept_stops, "write_latch", no_space)
        full.setattr(kept_stops, "remove_latch", no_space)
        stops.stop([""], "a person") if order == "stop" else stops.lift([""])
        assert "No space left on device" in stops.settled()
        full.undo()
        assert wait_until(lambda: stops.trouble == "")
    assert len(read_latches(folder)) == (order == "stop")
