"""Journals of a run: one program writes them, and the zones' file beside them."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import pytest

from navigation.config.several.each_robot import robots_of
from navigation.journal.journal import Journal, JournalError
from navigation.run import journals
from tests.navigation.loop.test_fleet_kill import hall


def opened(journal: Path, names: str, open_things: ExitStack) -> dict[str, Journal]:
    said: list[str] = []
    config = hall(journal, names)
    found = journals.open_journals(
        config, robots_of(config), None, open_things, lambda _robot, sentence: said.append(sentence)
    )
    assert said == []
    return found


@pytest.mark.parametrize(("names", "others"), [("ab", "ab"), ("ab", "c"), ("bc", "a")])
def test_two_programs_with_one_journal_do_not_write_one_file_of_zones(
    tmp_path: Path, names: str, others: str
) -> None:
    """Robots of other names have other journals: both wrote their zones to one file."""
    path = tmp_path / "journal"
    with ExitStack() as first, ExitStack() as second:
        assert list(opened(path, names, first)) == list(names)
        with pytest.raises(JournalError, match="is in use by another program"):
            opened(path, others, second)
    with ExitStack() as after:
        assert list(opened(path, others, after)) == list(others)
