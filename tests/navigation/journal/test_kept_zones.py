"""The file of changed zones: read back as it was written, and never used where it is damaged."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.journal.kept_zones import (
    KIND,
    VERSION,
    KeptZones,
    KeptZonesError,
    ZoneChange,
    changes_between,
    with_changes,
)
from navigation.shared.sealed import seal
from tests.navigation.journal.kept import circle

CHANGES = (
    ZoneChange(None, circle("new", robots=["ada"])),
    ZoneChange(circle("desk"), circle("desk", x_m=0.1 + 0.2)),
    ZoneChange(circle("door", "wait"), None),
)
ZONE = st.builds(
    circle,
    st.sampled_from(["a", "b", "c"]),
    st.sampled_from(["keep_out", "wait"]),
    x_m=st.floats(0.0, 9.0),
)
ZONES = st.lists(ZONE, max_size=3, unique_by=lambda one: one.name)


def keep(path: Path, changes: Sequence[ZoneChange]) -> None:
    kept = KeptZones(path)
    kept.write(kept.encoded(changes))


def test_changes_are_read_back_as_they_were(path: Path) -> None:
    keep(path, CHANGES)
    assert KeptZones(path).read() == CHANGES
    assert path.stat().st_mode & 0o777 == 0o600


@given(ZONES, ZONES)
def test_the_changes_lead_from_the_configured_zones_to_those_in_force(
    configured: list, in_force: list
) -> None:
    zones, said = with_changes(configured, changes_between(configured, in_force), ())
    assert sorted(zones, key=lambda one: one.name) == sorted(in_force, key=lambda one: one.name)
    assert len(said) == len(changes_between(configured, in_force))


def test_more_than_is_read_back_is_not_written(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keep(path, CHANGES[:1])
    monkeypatch.setattr("navigation.journal.kept_zones.MOST_BYTES", len(path.read_bytes()))
    assert KeptZones(path).read() == CHANGES[:1]
    with pytest.raises(KeptZonesError, match="must be at most"):
        keep(path, CHANGES)
    assert KeptZones(path).read() == CHANGES[:1]


def test_no_file_is_no_change_and_no_change_no_file(path: Path) -> None:
    assert KeptZones(path).read() == ()
    for changes in ((), CHANGES, ()):
        keep(path, changes)
    assert list(path.parent.iterdir()) == []


def test_a_byte_lost_or_changed_anywhere_is_damage_and_the_file_is_put_aside(path: Path) -> None:
    keep(path, CHANGES)
    whole = path.read_bytes()
    for place in range(0, len(whole), 7):
        for damaged in (
            whole[:place],
            whole[:place] + whole[place + 1 :],
            whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :],
        ):
            path.write_bytes(damaged)
            with pytest.raises(KeptZonesError, match=str(path)):
                KeptZones(path).read()
            assert path.read_bytes() == damaged
            aside = path.with_name("journal.damaged-1")
            assert KeptZones(path).put_aside() == f"{path}: kept as {aside.name}"
            assert aside.read_bytes() == damaged
            aside.unlink()
            assert KeptZones(path).read() == ()


def test_a_file_that_was_put_aside_is_never_overwritten(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("navigation.journal.kept_zones.MOST_ASIDE", 2)
    for number in (1, 2):
        path.write_text(str(number))
        assert f"damaged-{number}" in KeptZones(path).put_aside()
    path.write_text("3")
    with pytest.raises(KeptZonesError, match="cannot be put aside: 2 files are kept already"):
        KeptZones(path).put_aside()
    assert path.read_text() == "3"
    assert path.with_name("journal.damaged-2").read_text() == "2"


@pytest.mark.parametrize(
    "text",
    [
        "[1]",
        "{}x",
        '[{"configured": null, "in_force": null}]',
        '[{"in_force": null}]',
        '[{"configured": null, "in_force": {"name": "a", "kind": "slow", "circle": [1, 1, 1]}}]',
        '[{"configured": null, "in_force": {"name": "a", "kind": "wait", "mask": "/none.yaml"}}]',
    ],
)
def test_a_sealed_text_that_is_no_list_of_changes_is_damage_too(path: Path, text: str) -> None:
    path.write_bytes(seal(KIND, VERSION, text))
    with pytest.raises(KeptZonesError):
        KeptZones(path).read()


def test_another_version_is_not_guessed_at(path: Path) -> None:
    path.write_bytes(seal(KIND, VERSION + 1, json.dumps([])))
    with pytest.raises(KeptZonesError):
        KeptZones(path).read()


def test_the_file_lies_beside_the_journal() -> None:
    assert KeptZones.beside(Path("kept/arena.journal")).path == Path("kept/arena.journal.zones")
