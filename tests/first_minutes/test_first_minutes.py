"""Nothing that a newcomer types from the README, or from steps 1 to 4 of the tutorial, stumbles."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from pathlib import Path

import pytest

from tests.docs.fences import commands_in, examples_in

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TUTORIAL = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
COLD_S = 900.0
"""On a machine that has no compiled kernels yet."""
STUMBLES = ("Traceback", "No such file", "unexpected ")

PREPARED = re.compile(r"git clone |cd |python3 -m venv |(\S*/)?pip install |\. \S+/bin/activate")
"""Done by the fixture: the sources, the environment, the installation."""
OF_A_CHECKOUT = ("make run", "make test", "make docs")
"""Not in a wheel; ``.ci/run`` does them."""
OF_AN_ARENA = (
    ".venv/bin/clearway calibrate --live 0",
    ".venv/bin/clearway check arena.yaml",
    ".venv/bin/clearway run arena.yaml",
)
"""They need a camera, or its calibration."""
WATCHED = ".venv/bin/clearway demo"
"""Runs until Ctrl-C."""


def readme_commands() -> list[str]:
    """Each indented line of the README, without its comment."""
    lines = re.findall(r"^    (\S.*)$", re.sub(r"```.*?```", "", README, flags=re.S), re.M)
    return [re.sub(r"\s+#.*", "", line) for line in lines]


def tutorial_steps() -> str:
    """The tutorial up to step 4."""
    return TUTORIAL[: TUTORIAL.index("\n## 5. ")]


def environment_of(installed: Path) -> dict[str, str]:
    """A shell's after ``activate``, on a machine without a screen and without the checkout."""
    kept = {name: text for name, text in os.environ.items() if not name.startswith("PYTHON")}
    # over SSH the demo opens no browser
    return {**kept, "PATH": f"{installed / 'bin'}:{kept['PATH']}", "SSH_CONNECTION": "here"}


def run(command: str, folder: Path, installed: Path) -> None:
    """Run a command in a shell; AssertionError if it stumbles."""
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=environment_of(installed),
        capture_output=True,
        text=True,
        timeout=COLD_S,
        check=False,
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, f"{command}: exit code {done.returncode}\n{said}"
    assert not [word for word in STUMBLES if word in said], f"{command}\n{said}"


def run_python(program: str, folder: Path, installed: Path) -> None:
    """Run a block of Python as a file."""
    (folder / "block.py").write_text(program, encoding="utf-8")
    run("python block.py", folder, installed)


def test_each_command_of_the_readme_is_run_or_known_not_to_be() -> None:
    commands = readme_commands()
    assert len(commands) > 15
    others = {*OF_A_CHECKOUT, *OF_AN_ARENA}
    assert others < set(commands)
    for command in set(commands) - others:
        assert PREPARED.match(command) or command.startswith(".venv/bin/clearway "), command


@pytest.mark.timeout(COLD_S)
def test_the_readme_s_commands_run_in_their_order(tmp_path: Path, installed: Path) -> None:
    (tmp_path / ".venv").symlink_to(installed)
    for command in dict.fromkeys(readme_commands()):  # some are shown twice
        if command == WATCHED:
            watch(command, tmp_path, installed)
        elif not PREPARED.match(command) and command not in (*OF_A_CHECKOUT, *OF_AN_ARENA):
            run(command, tmp_path, installed)
    for example in examples_in(README):
        run_python(example.text, tmp_path, installed)


def watch(command: str, folder: Path, installed: Path) -> None:
    """Run a command until it names its page, end it by Ctrl-C, and look at its end."""
    with subprocess.Popen(
        ["bash", "-c", f"exec {command}"],
        cwd=folder,
        env=environment_of(installed),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        assert process.stdout is not None
        said = ""
        for line in process.stdout:
            said += line
            if line.startswith("dashboard at http://"):
                process.send_signal(signal.SIGINT)
                break
        said += process.stdout.read()
    assert "dashboard at" in said, said
    assert process.returncode == 0, said
    assert not [word for word in STUMBLES if word in said], said


@pytest.mark.timeout(COLD_S)
def test_the_tutorial_s_first_four_steps_run_in_their_order(
    tmp_path: Path, installed: Path
) -> None:
    for line in re.findall(r"^```sh\n(.*?)^```", tutorial_steps(), re.M | re.S):
        for command in line.splitlines():
            assert PREPARED.match(command), f"{command}: is not run here"
    for example in examples_in(tutorial_steps()):
        if example.kind == "python":
            run_python(example.text, tmp_path, installed)
            continue
        for command, _printed in commands_in(example.text):
            run(command, tmp_path, installed)
