"""Zones of a running program: what people change, take back, and find again after a restart."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

from navigation.config.zones import MOST_ZONES, ZoneSection
from navigation.journal.kept_zones import MOST_BYTES, KeptZones, KeptZonesError
from navigation.journal.zones_writer import RETRY_S
from navigation.loop.zones_in_force import ZonesInForce
from navigation.mission.mission import MissionError
from navigation.shared.sealed import seal
from navigation.shared.whole_file import UnwrittenFileError
from tests.navigation.config.test_zones import write_mask
from tests.navigation.journal.kept import circle
from tests.support.waiting import wait_until

DESK, DOOR = circle("desk"), circle("door", "wait")


def words(zones: ZonesInForce) -> dict[str, str]:
    return {one.name: one.in_a_word for one in zones.changes()}


def test_a_change_shows_beside_the_configuration() -> None:
    zones = ZonesInForce([DESK, DOOR], [""])
    assert words(zones) == {}
    zones.put(circle("new"))
    zones.put(circle("desk", x_m=2.0))
    zones.remove("door")
    assert words(zones) == {"desk": "changed", "door": "removed", "new": "added"}
    zones.undo()
    zones.undo()
    assert words(zones) == {"new": "added"}
    zones.put(DOOR)
    assert words(zones) == {"new": "added"}


def test_each_change_is_counted_and_announced() -> None:
    zones = ZonesInForce([], [""])
    called: list[int] = []
    zones.changed = lambda: called.append(zones.revision)
    zones.put(DESK)
    zones.remove("desk")
    zones.undo()
    assert called == [1, 2, 3]


def test_what_cannot_be_changed_is_refused_and_changes_nothing() -> None:
    zones = ZonesInForce([DESK], ["ada"])
    with pytest.raises(MissionError, match="there are desk"):
        zones.remove("door")
    with pytest.raises(MissionError, match="no change"):
        zones.undo()
    with pytest.raises(MissionError, match="robot 'eve': there is ada"):
        zones.put(circle("a", robots=["eve"]))
    assert zones.sections == (DESK,)
    assert zones.revision == 0
    full = ZonesInForce([circle(f"z{number}") for number in range(MOST_ZONES)], [""])
    with pytest.raises(MissionError, match="there are 101 zones: must be at most 100"):
        full.put(circle("more"))
    full.put(circle("z7", x_m=2.0))


def test_the_next_run_begins_with_the_changes(tmp_path: Path) -> None:
    kept = KeptZones(tmp_path / "zones")
    first = ZonesInForce([DESK, DOOR], [""])
    assert first.restore(kept) == []
    first.put(circle("new"))
    first.put(circle("desk", x_m=2.0))
    first.remove("door")
    second = ZonesInForce([DESK, DOOR], [""])
    said = second.restore(KeptZones(tmp_path / "zones"))
    assert {one.name: one for one in second.sections} == {one.name: one for one in first.sections}
    assert words(second) == words(first)
    assert len(said) == 3
    assert second.revision == 1
    second.remove("new")
    third = ZonesInForce([DESK, DOOR], [""])
    third.restore(KeptZones(tmp_path / "zones"))
    assert words(third) == {"desk": "changed", "door": "removed"}


def test_without_a_difference_nothing_is_kept(tmp_path: Path) -> None:
    zones = ZonesInForce([], [""])
    zones.restore(KeptZones(tmp_path / "zones"))
    zones.put(DESK)
    assert (tmp_path / "zones").exists()
    zones.undo()
    assert not (tmp_path / "zones").exists()


def test_a_configuration_that_was_changed_since_holds(tmp_path: Path) -> None:
    first = ZonesInForce([DESK, DOOR], [""])
    first.restore(KeptZones(tmp_path / "zones"))
    first.remove("desk")
    first.put(circle("door", "wait", x_m=2.0))
    edited = circle("desk", x_m=1.5)
    second = ZonesInForce([edited, DOOR], [""])
    said = second.restore(KeptZones(tmp_path / "zones"))
    assert second.sections == (edited, circle("door", "wait", x_m=2.0))
    assert "desk" in said[0]
    assert "configuration" in said[0]


def masked(folder: Path) -> ZoneSection:
    """A keep-out zone of the mask beside."""
    mask = {"name": "desk", "kind": "keep_out", "mask": folder / "mask.yaml"}
    return ZoneSection.model_validate(mask)


@pytest.mark.parametrize("becomes", ["other cells", "no picture", "nothing"])
def test_a_mask_holds_in_the_next_run_as_it_was_drawn(tmp_path: Path, becomes: str) -> None:
    write_mask(tmp_path)
    first = ZonesInForce([], [""])
    first.restore(KeptZones(tmp_path / "zones"))
    first.put(masked(tmp_path))
    write_mask(tmp_path, occupied=False)
    if becomes != "other cells":
        (tmp_path / "mask.pgm").unlink()
    if becomes == "nothing":
        (tmp_path / "mask.yaml").unlink()
    second = ZonesInForce([], [""])
    said = second.restore(KeptZones(tmp_path / "zones"))
    assert said == ["zone 'desk', added while an earlier run was under way: holds again"]
    assert second.zones() == first.zones()


def test_a_configured_mask_whose_cells_have_changed_since_holds(tmp_path: Path) -> None:
    write_mask(tmp_path)
    first = ZonesInForce([masked(tmp_path)], [""])
    first.restore(KeptZones(tmp_path / "zones"))
    first.remove("desk")
    write_mask(tmp_path, occupied=False)
    edited = masked(tmp_path)
    second = ZonesInForce([edited], [""])
    (sentence,) = second.restore(KeptZones(tmp_path / "zones"))
    assert sentence.endswith("the configuration has changed it since, and holds")
    assert second.sections == (edited,)


def test_a_zone_for_a_robot_that_is_gone_is_dropped_and_said(tmp_path: Path) -> None:
    first = ZonesInForce([], ["ada", "bob"])
    first.restore(KeptZones(tmp_path / "zones"))
    first.put(circle("desk", robots=["bob"]))
    second = ZonesInForce([], ["ada"])
    assert second.restore(KeptZones(tmp_path / "zones")) == [
        "zone 'desk', added while an earlier run was under way: dropped: there is no robot 'bob' "
        "in this run"
    ]
    assert second.sections == ()


def test_a_zone_for_two_robots_of_which_one_is_gone_holds_for_the_other(tmp_path: Path) -> None:
    first = ZonesInForce([], ["ada", "bob"])
    first.restore(KeptZones(tmp_path / "zones"))
    first.put(circle("desk", robots=["ada", "bob"]))
    second = ZonesInForce([], ["ada"])
    assert second.restore(KeptZones(tmp_path / "zones")) == [
        "zone 'desk', added while an earlier run was under way: holds again for ada; there is no "
        "robot 'bob' in this run"
    ]
    assert second.sections == (circle("desk", robots=["ada"]),)
    assert [one.is_for("ada") for one in second.zones()] == [True]


def test_zones_hold_beside_those_that_the_configuration_has_got_since(tmp_path: Path) -> None:
    """None may be dropped, a keep-out zone could be; more than these there cannot be."""
    first = begun(tmp_path)
    for number in range(MOST_ZONES):
        first.put(circle(f"z{number}"))
    second = ZonesInForce([circle(f"y{number}") for number in range(MOST_ZONES)], [""])
    *said, last = second.restore(KeptZones(tmp_path / "zones"))
    assert len(said) == MOST_ZONES
    assert last == (
        "200 zones: must be at most 100: all hold, and none is added before some are removed"
    )
    assert len(second.zones()) == 2 * MOST_ZONES
    for zone in (circle("new"), circle("z7", x_m=2.0)):
        with pytest.raises(MissionError, match="zones: must be at most 100"):
            second.put(zone)
    second.remove("z7")
    second.undo()
    assert len(second.zones()) == 2 * MOST_ZONES


def test_a_change_that_cannot_be_kept_holds_and_says_so(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    zones = ZonesInForce([], [""])
    zones.restore(KeptZones(folder / "zones"))
    folder.write_text("in the way")
    zones.put(DESK)
    assert zones.sections == (DESK,)
    assert "restart would not know" in zones.trouble
    zones.put(DOOR)
    folder.unlink()
    assert wait_until(lambda: zones.trouble == "")  # it is tried again without another change
    again = ZonesInForce([], [""])
    again.restore(KeptZones(folder / "zones"))
    assert again.sections == (DESK, DOOR)


def test_a_run_that_is_over_writes_no_change_that_failed_over_those_of_the_next(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "folder"
    first = ZonesInForce([], [""])
    first.restore(KeptZones(folder / "zones"))
    folder.write_text("in the way")
    first.put(DESK)
    first.end()
    folder.unlink()
    second = ZonesInForce([], [""])
    second.restore(KeptZones(folder / "zones"), first)
    second.put(DOOR)
    time.sleep(1.5 * RETRY_S)  # time in which a writer of the first run would try again
    again = ZonesInForce([], [""])
    again.restore(KeptZones(folder / "zones"))
    assert again.sections == (DESK, DOOR)


@pytest.mark.parametrize("has_file", [False, True])
def test_a_run_that_begins_again_has_the_changes_of_the_one_before(
    tmp_path: Path, *, has_file: bool
) -> None:
    """With a file too, where the disk was full; the configuration's own changes hold."""
    first = ZonesInForce([DESK, DOOR], [""])
    first.put(circle("new"))
    first.put(circle("desk", x_m=2.0))
    second = ZonesInForce([circle("desk", x_m=1.5), DOOR], [""])
    said = second.restore(KeptZones(tmp_path / "zones") if has_file else None, first)
    assert second.sections == (circle("desk", x_m=1.5), DOOR, circle("new"))
    assert len(said) == 2
    assert (tmp_path / "zones").exists() == has_file


@contextmanager
def full_disk() -> Iterator[list[bytes]]:
    """The contents that were to be written meanwhile."""
    refused: list[bytes] = []

    def write_whole(path: Path, data: bytes, **_how: bool) -> None:
        refused.append(data)
        raise UnwrittenFileError(f"{path}: cannot be written: no space left on device")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("navigation.journal.kept_zones.write_whole", write_whole)
        yield refused


@contextmanager
def hanging_disk() -> Iterator[threading.Event]:
    """Disk whose first write hangs until the event is set."""
    goes_on, first = threading.Event(), [True]

    def write_whole(path: Path, data: bytes, **_how: bool) -> None:
        if first and first.pop():
            assert goes_on.wait(30.0)
        path.write_bytes(data)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("navigation.journal.kept_zones.write_whole", write_whole)
        patch.setattr("navigation.journal.zones_writer.ANSWER_S", 0.1)
        try:
            yield goes_on
        finally:
            goes_on.set()


def begun(
    folder: Path, before: ZonesInForce | None = None, configured: Sequence[ZoneSection] = ()
) -> ZonesInForce:
    zones = ZonesInForce(configured, [""])
    zones.restore(KeptZones(folder / "zones"), before)
    return zones


def names(zones: ZonesInForce) -> list[str]:
    return sorted(one.name for one in zones.sections)


def test_a_zone_that_is_back_as_configured_holds_after_a_reload(tmp_path: Path) -> None:
    """The file, older than a full disk, said that it had been removed."""
    first = begun(tmp_path, configured=[DESK, DOOR])
    first.remove("desk")
    first.put(circle("new"))
    first.put(circle("stays"))
    with full_disk():
        first.put(DESK)
        first.remove("new")
        first.end()
    second = begun(tmp_path, first, [DESK, DOOR])
    assert names(second) == ["desk", "door", "stays"]
    assert second.trouble == ""
    assert [one.name for one in KeptZones(tmp_path / "zones").read()] == ["stays"]


def test_a_reload_with_another_journal_has_its_changes_too(tmp_path: Path) -> None:
    begun(tmp_path / "other").put(DOOR)
    first = begun(tmp_path)
    first.put(DESK)
    first.end()
    second = begun(tmp_path / "other", first)
    assert names(second) == names(begun(tmp_path / "other")) == ["desk", "door"]


def test_a_full_disk_is_tried_again_with_what_was_encoded_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mask of many islands takes half a second, which held all robots each time."""
    encoded: list[str] = []

    def counting(kind: str, version: int, text: str) -> bytes:
        encoded.append(text)
        return seal(kind, version, text)

    monkeypatch.setattr("navigation.journal.kept_zones.seal", counting)
    monkeypatch.setattr("navigation.journal.zones_writer.RETRY_S", 0.02)
    zones = begun(tmp_path)
    with full_disk() as refused:
        zones.put(DESK)
        assert wait_until(lambda: len(refused) > 3)
        zones.end()
    assert len(encoded) == 1
    assert len(set(refused)) == 1


def test_more_zones_than_a_file_may_have_are_not_encoded_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tries: list[str] = []

    def too_long(_kind: str, _version: int, text: str) -> bytes:
        tries.append(text)
        return bytes(MOST_BYTES + 1)

    monkeypatch.setattr("navigation.journal.kept_zones.seal", too_long)
    monkeypatch.setattr("navigation.journal.zones_writer.RETRY_S", 0.02)
    zones = begun(tmp_path)
    zones.put(DESK)
    time.sleep(0.3)  # time for a dozen attempts
    assert "must be at most" in zones.trouble
    assert len(tries) == 1


def test_a_run_that_is_over_takes_no_change_that_the_next_would_not_know(tmp_path: Path) -> None:
    first = begun(tmp_path)
    first.put(DESK)
    first.end()
    with pytest.raises(MissionError, match="this run is over"):
        first.put(DOOR)
    with pytest.raises(MissionError, match="this run is over"):
        first.undo()
    assert names(first) == names(begun(tmp_path, first)) == ["desk"]


def test_the_newest_change_is_written_although_the_run_ended_while_the_disk_hung(
    tmp_path: Path,
) -> None:
    first = begun(tmp_path)
    with hanging_disk() as goes_on:
        first.put(DESK)
        first.put(DOOR)
        first.end()
        goes_on.set()
        assert wait_until(lambda: names(begun(tmp_path)) == ["desk", "door"])


def test_a_run_ends_once_its_changes_are_on_the_disk(tmp_path: Path) -> None:
    first = begun(tmp_path)
    with hanging_disk() as goes_on:
        first.put(DESK)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("navigation.journal.zones_writer.ANSWER_S", 30.0)
            threading.Timer(0.1, goes_on.set).start()
            first.end()
        assert names(begun(tmp_path)) == ["desk"]


def test_a_write_that_hung_in_the_run_before_comes_before_those_of_the_next(
    tmp_path: Path,
) -> None:
    first = begun(tmp_path)
    others = set(threading.enumerate())
    with hanging_disk() as goes_on:
        first.put(DESK)
        first.end()
        second = begun(tmp_path, first)
        second.put(DOOR)
        goes_on.set()
        assert wait_until(lambda: set(threading.enumerate()) <= others)
    assert second.trouble == ""
    assert names(begun(tmp_path)) == ["desk", "door"]


def test_changes_of_the_run_before_hold_beside_a_damaged_file(tmp_path: Path) -> None:
    (tmp_path / "zones").write_text("torn")
    first = ZonesInForce([], [""])
    first.put(DESK)
    zones = ZonesInForce([], [""])
    with pytest.raises(KeptZonesError, match="damaged"):
        zones.restore(KeptZones(tmp_path / "zones"), first)
    assert zones.sections == (DESK,)


def test_lost_changes_are_an_error_and_further_ones_are_kept(tmp_path: Path) -> None:
    (tmp_path / "zones").write_text("torn")
    zones = ZonesInForce([DESK], [""])
    with pytest.raises(KeptZonesError, match="damaged"):
        zones.restore(KeptZones(tmp_path / "zones"))
    assert zones.sections == (DESK,)
    zones.put(DOOR)
    assert (tmp_path / "zones").read_text() == "torn"
    kept = KeptZones(tmp_path / "zones")
    kept.put_aside()
    zones.keep_in(kept)
    again = ZonesInForce([DESK], [""])
    again.restore(KeptZones(tmp_path / "zones"))
    assert again.sections == (DESK, DOOR)
