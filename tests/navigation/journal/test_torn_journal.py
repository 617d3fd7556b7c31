"""A journal that lost bytes or has a bit flipped: the last entry, or nothing and a sentence."""

from collections.abc import Iterator
from pathlib import Path

from navigation.journal.journal import Journal
from navigation.mission.mission import Event
from tests.navigation.journal.kept import DRIVING, OWNER, PLAN

STOPPED = DRIVING.after(Event.STOP, "stopped")


def harms(files: dict[str, bytes]) -> Iterator[tuple[str, bytes]]:
    """Each file cut at every length, and with one bit flipped at each byte."""
    for name, whole in files.items():
        for length in range(len(whole)):
            yield name, whole[:length]
        for place, byte in enumerate(whole):
            yield name, whole[:place] + bytes([byte ^ (1 << place % 8)]) + whole[place + 1 :]


def test_a_cut_or_a_flipped_bit_at_any_byte_never_brings_back_the_entry_before(path: Path) -> None:
    with Journal(path, OWNER) as journal:
        journal.keep(DRIVING, PLAN, 0.0)
        journal.keep(STOPPED, None, 1.0)
        files = {file.name: file.read_bytes() for file in path.parent.iterdir()}
    assert len(files["journal"]) > 500
    for name, harmed in harms(files):
        for file in path.parent.iterdir():
            file.unlink()
        for other, whole in files.items():
            path.with_name(other).write_bytes(harmed if other == name else whole)
        with Journal(path, OWNER) as journal:
            assert journal.mission() is None, f"{name}, {len(harmed)} bytes"
            assert journal.plan() is None
            assert journal.remark.startswith(f"journal {path}: is ")
            assert "kept as journal.damaged-1; the run begins without it" in journal.remark
        assert path.with_name("journal.damaged-1").read_bytes() == harmed


def test_a_kill_while_an_entry_is_written_leaves_the_one_before_it(path: Path) -> None:
    with Journal(path, OWNER) as journal:
        journal.keep(DRIVING, PLAN, 0.0)
        whole = path.read_bytes()
    for length in range(0, len(whole), 50):
        path.with_name(".journal.new").write_bytes(whole[:length])
        with Journal(path, OWNER) as journal:
            assert (journal.mission(), journal.remark) == (DRIVING, "")
            journal.keep(DRIVING.with_visited(2), None, 0.0)
            assert journal.trouble == ""
            journal.keep(DRIVING, PLAN, 0.0)
