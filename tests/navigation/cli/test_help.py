"""The help of every command, and the reference that is made from it."""

import shlex
from pathlib import Path

import click
import pytest

from navigation.cli.examples import EXAMPLES
from navigation.cli.main import COMMANDS, clearway, run
from navigation.cli.reference import commands_markdown

ROOT = Path(__file__).parents[3]


def test_every_command_has_an_example_and_no_other_has() -> None:
    assert list(EXAMPLES) == list(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_an_example_s_command_line_parses(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    program, called, *arguments = shlex.split(EXAMPLES[name].line)
    assert (program, called) == ("clearway", name)
    with click.Context(clearway, info_name="clearway") as group:
        command = clearway.get_command(group, name)
        assert command is not None
        # an argument that does not parse is a UsageError
        command.make_context(name, arguments, parent=group)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_ends_with_the_example(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([name, "--help"]) == 0
    last = capsys.readouterr().out.rstrip().splitlines()[-1]
    assert last.strip() == EXAMPLES[name].line


def test_the_reference_is_what_the_parser_says() -> None:
    """Where this fails: `python -m navigation.cli.reference > docs/reference/commands.md`."""
    assert (ROOT / "docs/reference/commands.md").read_text() == commands_markdown()
