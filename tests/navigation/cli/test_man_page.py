"""The manual page has all that the parser knows, and reads well in man."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from navigation.cli.examples import EXAMPLES
from navigation.cli.main import COMMANDS
from navigation.cli.man_page import man_page

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def shown() -> str:
    """The page as a terminal shows it, in lines too long to be wrapped."""
    if shutil.which("groff") is None:
        pytest.skip("there is no groff here: bash .ci/packages shells installs it")
    done = subprocess.run(
        ["groff", "-man", "-Tascii", "-ww", "-P-cbou", "-rLL=500n"],
        input=man_page(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    return done.stdout


def test_it_has_the_parts_of_a_manual_page_in_their_order(shown: str) -> None:
    parts = ["NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "COMMANDS", "EXIT STATUS"]
    assert re.findall(r"^[A-Z ]+$", shown, re.M)[:6] == parts


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_there_with_its_example_ready_to_copy(name: str, shown: str) -> None:
    section = shown.partition(f"\n   clearway {name} ")[2].partition("\n   clearway ")[0]
    lines = [line.strip() for line in section.splitlines()]
    assert EXAMPLES[name].line in lines
    assert f"Example: {EXAMPLES[name].does}" in lines


def test_no_option_is_missing(shown: str) -> None:
    reference = (ROOT / "docs" / "reference" / "commands.md").read_text()
    options = set(re.findall(r"^\| `(?:-\w, )?(--[a-z-]+)", reference, re.M))
    assert len(options) > 50
    assert [option for option in sorted(options) if option not in shown] == []
