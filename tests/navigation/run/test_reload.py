"""The configuration read again while a run goes on."""

from __future__ import annotations

from pathlib import Path

from navigation.config import Config, load_config
from navigation.run.reload import Reloader
from tests.support.broken_config import break_file


class Heard:
    """A reloader of one file, and what it told."""

    def __init__(self, file: Path) -> None:
        self.said: list[tuple[str, str]] = []
        self.fresh: list[Config] = []
        self.reloader = Reloader(
            file,
            load_config(file, {}),
            load=lambda path: load_config(path, {}),
            say=lambda level, sentence: self.said.append((level, sentence)),
            good=self.fresh.append,
        )

    def ask(self) -> None:
        self.reloader.ask()
        self.reloader.join(20.0)


def test_a_changed_file_is_handed_over_with_the_sections_that_changed(config_file: Path) -> None:
    heard = Heard(config_file)
    text = config_file.read_text()
    config_file.write_text(text.replace("margin_m: 0.015", "margin_m: 0.02"))
    heard.ask()
    assert [config.planning.margin_m for config in heard.fresh] == [0.02]
    assert "planning changed" in heard.said[0][1]


def test_a_broken_file_changes_nothing_and_every_error_is_told(config_file: Path) -> None:
    heard = Heard(config_file)
    break_file(config_file)
    heard.ask()
    ((level, sentence),) = heard.said
    assert level == "error"
    assert "continues with the last good configuration" in sentence
    assert "must be a number" in sentence
    assert heard.fresh == []


def test_an_unchanged_file_is_read_and_nothing_happens(config_file: Path) -> None:
    heard = Heard(config_file)
    heard.ask()
    assert "nothing has changed" in heard.said[0][1]
    assert heard.fresh == []
