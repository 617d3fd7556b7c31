"""Shell completion, in the real shells: what a person sees who presses the tab key."""

import os
import pty
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from navigation.cli.main import run

ROOT = Path(__file__).parents[3]
PATIENCE_S = 60.0
"""Each press of the key starts Python; on a busy machine that takes seconds."""


def _need(shell: str) -> str:
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"there is no {shell} here: bash .ci/packages shells installs it")
    return program


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """One in which `clearway` is this checkout's, and nobody's start files are read."""
    program = tmp_path / "bin" / "clearway"
    program.parent.mkdir()
    program.write_text(
        f'#!/bin/sh\nexec {sys.executable} -c "from navigation.cli.main import main; main()" "$@"\n'
    )
    program.chmod(0o755)
    kept = {name: os.environ[name] for name in ("LANG",) if name in os.environ}
    return {
        **kept,
        "PATH": f"{program.parent}:{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "HOME": str(tmp_path),
        "TERM": "xterm",
    }


def _typed(arguments: list[str], environment: dict[str, str], steps: list[tuple[str, str]]) -> str:
    """Type each step's keys into a shell at a terminal, waiting for what it has to show."""
    child, terminal = pty.fork()
    if child == 0:
        os.execvpe(arguments[0], arguments, environment)
    try:
        for keys, wanted in steps:
            os.write(terminal, keys.encode())
            seen = _read_until(terminal, wanted)
    finally:
        os.close(terminal)
        os.waitpid(child, 0)
    return seen


def _read_until(terminal: int, wanted: str) -> str:
    seen = ""
    until_s = time.monotonic() + PATIENCE_S
    while wanted not in seen:
        assert time.monotonic() < until_s, f"{wanted!r} did not come; the shell showed {seen!r}"
        if select.select([terminal], [], [], 0.1)[0]:
            seen += os.read(terminal, 4096).decode(errors="replace")
    return seen


# the words are written apart, so that the echo of what is typed is not taken for the answer
READY = "echo re''ady\n"


def test_bash_completes_commands_and_options(environment: dict[str, str]) -> None:
    _typed(
        [_need("bash"), "--norc", "-i"],
        environment,
        [
            ('eval "$(clearway completion bash)"; ' + READY, "ready"),
            ("clearway ext\t", "extract"),
            (" --ren\t", "--render"),
        ],
    )


def test_zsh_completes_commands_and_options(environment: dict[str, str]) -> None:
    _typed(
        [_need("zsh"), "-f", "-i"],
        environment,
        [
            ("autoload -Uz compinit && compinit -u -D; " + READY, "ready"),
            ('eval "$(clearway completion zsh)"; ' + READY, "ready"),
            ("clearway ext\t", "extract"),
            ("--ren\t", "--render"),
        ],
    )


@pytest.mark.parametrize(
    ("typed", "wanted"), [("clearway ext", "extract"), ("clearway extract --ren", "--render")]
)
def test_fish_completes_commands_and_options(
    typed: str, wanted: str, environment: dict[str, str]
) -> None:
    script = f'clearway completion fish | source; complete -C "{typed}"'
    done = subprocess.run(
        [_need("fish"), "--no-config", "-c", script],
        env=environment,
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE_S,
        check=True,
    )
    assert wanted in done.stdout.split()


def test_another_shell_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["completion", "tcsh"]) == 2
    assert "'bash', 'zsh', 'fish'" in capsys.readouterr().err
