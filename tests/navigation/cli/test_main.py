"""The entry point: exit codes, one-sentence errors, lazy commands."""

from __future__ import annotations

import errno
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest

from navigation.cli import main as entry
from navigation.shared.garbage import IMPORTED, USUAL
from planner.scene import SceneError
from vision.camera.camera import CameraError


def _install(monkeypatch: pytest.MonkeyPatch, body: Callable[[], object]) -> None:
    """Make ``clearway plan`` call ``body``."""

    @click.command()
    @click.option("--radius", type=float)
    def command(radius: float | None) -> object:
        return body()

    monkeypatch.setattr(sys.modules[__name__], "probe", command, raising=False)
    monkeypatch.setitem(entry.COMMANDS, "plan", entry.ListedCommand(f"{__name__}:probe", "help"))


def _raise(error: BaseException) -> Callable[[], object]:
    def body() -> object:
        raise error

    return body


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (SceneError("map.png: not a picture"), 2),
        (CameraError("camera 0: busy"), 2),
        (FileNotFoundError(2, "No such file or directory", "a.png"), 2),
        (click.BadParameter("must be > 0"), 2),
        (OSError(28, "No space left on device"), 1),
        (ValueError("a bug in numpy's land"), 1),
        (KeyError("x"), 1),
        (KeyboardInterrupt(), 130),
    ],
)
def test_each_error_has_its_exit_code(
    error: BaseException, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    _install(monkeypatch, _raise(error))
    assert entry.run(["plan"]) == code


def test_a_configuration_error_exits_with_78(monkeypatch: pytest.MonkeyPatch) -> None:
    from navigation.config import parse_config

    _install(monkeypatch, lambda: parse_config("arena: 3"))
    assert entry.run(["plan"]) == 78


@pytest.mark.parametrize("code", [0, 3])
def test_a_command_may_return_its_exit_code(code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, lambda: code)
    assert entry.run(["plan"]) == code


def test_our_error_is_one_line_on_stderr(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _install(monkeypatch, _raise(SceneError("map.png: is not a picture")))
    entry.run(["plan"])
    out, err = capsys.readouterr()
    assert (out, err) == ("", "clearway: error: map.png: is not a picture\n")


def test_a_missing_file_is_named_without_errno(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _install(monkeypatch, Path("/no/such/file").read_bytes)
    assert entry.run(["plan"]) == 2
    assert capsys.readouterr().err == "clearway: error: /no/such/file: No such file or directory\n"


@pytest.mark.parametrize("arguments", [["--debug", "plan"], ["plan", "--debug"]])
def test_debug_shows_the_traceback_wherever_it_stands(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _install(monkeypatch, _raise(SceneError("x")))
    assert entry.run(arguments) == 2
    assert "Traceback" in capsys.readouterr().err


def test_without_debug_there_is_no_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _install(monkeypatch, _raise(RuntimeError("boom")))
    assert entry.run(["plan"]) == 1
    err = capsys.readouterr().err
    assert "Traceback" not in err
    assert "RuntimeError: boom" in err


def test_debug_behind_a_double_dash_is_left_to_the_command() -> None:
    assert entry._take_debug(["plan", "--", "--debug"]) == (["plan", "--", "--debug"], False)


def test_the_environment_can_ask_for_debug(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("CLEARWAY_DEBUG", "1")
    _install(monkeypatch, _raise(SceneError("x")))
    entry.run(["plan"])
    assert "Traceback" in capsys.readouterr().err


def test_a_misspelt_command_is_corrected(capsys: pytest.CaptureFixture[str]) -> None:
    assert entry.run(["plam"]) == 2
    assert "did you mean 'plan'?" in capsys.readouterr().err


def test_an_unknown_command_lists_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert entry.run(["xyzzy"]) == 2
    assert "extract" in capsys.readouterr().err


def test_an_unknown_option_is_a_usage_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _install(monkeypatch, lambda: 0)
    assert entry.run(["plan", "--radios", "3"]) == 2
    err = capsys.readouterr().err
    assert "--radios" in err
    assert err.count("\n") == 1


def test_no_command_says_in_five_lines_how_to_begin_and_fails(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert entry.run([]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    first, *ways = err.splitlines()
    assert first.startswith("Clearway: ")
    names = [way.split()[1] for way in ways]
    assert names == ["demo", "plan", "run", "--help"]
    assert all(way.startswith("  clearway ") and len(way) <= 80 for way in ways)
    assert all(name in entry.COMMANDS for name in names[:3])


@pytest.mark.parametrize("command", [[], ["marker"]])
def test_help_may_be_a_word(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert entry.run([*command, "--help"]) == 0
    shown = capsys.readouterr().out
    assert entry.run(["help", *command]) == 0
    assert capsys.readouterr().out == shown


def test_help_of_a_command_that_there_is_not_is_an_error(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert entry.run(["help", "fly"]) == 2
    assert "no command 'fly'" in capsys.readouterr().err


def test_help_lists_every_command_with_its_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert entry.run(["--help"]) == 0
    out = capsys.readouterr().out
    for name, listed in entry.COMMANDS.items():
        assert f"  {name} " in out
        assert listed.help.split()[0] in out


def test_version_is_the_distribution_s(capsys: pytest.CaptureFixture[str]) -> None:
    from importlib.metadata import version

    assert entry.run(["--version"]) == 0
    assert capsys.readouterr().out == f"clearway {version('clearway')}\n"


HEAVY = ("numpy", "cv2", "numba", "pydantic", "serial", "networkx", "yaml")


def test_help_imports_nothing_heavy() -> None:
    script = (
        "import sys\n"
        "from navigation.cli.main import run\n"
        "run(['--help'])\n"
        f"sys.exit(','.join(m for m in {HEAVY} if m in sys.modules) or 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_a_run_is_refused_before_the_kernels_compiler_is_imported() -> None:
    refused = ended(
        "import atexit, sys\natexit.register(lambda: print('numba' in sys.modules))",
        "run",
        "gone.yaml",
    )
    assert (refused.returncode, refused.stdout) == (78, "False\n")
    assert "gone.yaml" in refused.stderr


def test_help_is_quick() -> None:
    """Imports are what it takes its time for: beyond click's own, a handful."""
    script = (
        "import sys, click\n"
        "click.Command('any').main(['--help'], standalone_mode=False)\n"
        "before = set(sys.modules)\n"
        "from navigation.cli.main import run\n"
        "run(['-h'])\n"
        "print(*sorted(set(sys.modules) - before), file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True
    )
    assert len(done.stderr.split()) <= 20, done.stderr


def ended(before: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The whole program after ``before`` in one interpreter."""
    script = (
        f"{before}\nimport sys\nfrom navigation.cli.main import main\n"
        f"sys.argv = ['clearway', *{arguments!r}]\nmain()\n"
    )
    return subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )


def test_the_end_writes_all_output_calls_what_was_registered_and_keeps_the_code() -> None:
    told = ended("import atexit; atexit.register(print, 'bye')", "schema")
    assert (told.returncode, told.stderr) == (0, "")
    json.loads(told.stdout.removesuffix("bye\n"))
    assert told.stdout.endswith("}\nbye\n")
    wrong = ended("import atexit; atexit.register(print, 'bye')", "no-such-command")
    assert (wrong.returncode, wrong.stdout) == (2, "bye\n")
    assert "no-such-command" in wrong.stderr


@pytest.mark.parametrize(("command", "first"), [("plan", IMPORTED), ("replay", USUAL[0])])
def test_only_commands_that_load_kernels_and_answer_once_postpone_the_garbage(
    command: str, first: int
) -> None:
    counted = "import atexit, gc; atexit.register(lambda: print(gc.get_threshold()[0]))"
    told = ended(counted, command, "--help")
    assert int(told.stdout.splitlines()[-1]) == first


def test_the_end_waits_for_threads_as_the_interpreter_does() -> None:
    # the thread writes when the main program has been at its end for a time
    waits = (
        "import sys, threading, time\n"
        "said, write = threading.Event(), sys.stdout.write\n"
        "def noted(text): said.set(); return write(text)\n"
        "sys.stdout.write = noted\n"
        "def last(): said.wait(); time.sleep(0.3); print('the last word')\n"
        "threading.Thread(target=last).start()"
    )
    told = ended(waits, "--version")
    assert (told.returncode, told.stderr) == (0, "")
    assert told.stdout.endswith("the last word\n")


def test_a_reader_that_goes_away_is_met_with_silence() -> None:
    """`clearway schema | head -1`: no traceback, and the code that a shell gives SIGPIPE."""
    script = "import sys; from navigation.cli.main import run; sys.exit(run(['schema']))"
    done = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert done.stdout is not None
    assert done.stderr is not None
    done.stdout.close()
    error = done.stderr.read()
    done.stderr.close()
    assert (done.wait(60), error) == (141, "")


@pytest.mark.parametrize("name", ["check", "init", "schema"])
def test_each_command_explains_itself(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert entry.run([name, "--help"]) == 0
    assert "Usage: clearway" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("variable", "value", "coloured"),
    [("NO_COLOR", "1", False), ("NO_COLOR", "", True), ("TERM", "dumb", False)],
)
def test_colours_are_left_out_where_they_are_not_wanted(
    monkeypatch: pytest.MonkeyPatch, variable: str, value: str, coloured: bool
) -> None:
    for name in ("NO_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(variable, value)
    said: list[bool | None] = []
    command = click.Command(
        "probe", callback=lambda: said.append(click.get_current_context().color)
    )
    monkeypatch.setattr(entry.LazyGroup, "get_command", lambda *_: command)
    monkeypatch.setitem(entry.COMMANDS, "probe", entry.ListedCommand("", ""))
    assert entry.run(["probe"]) == 0
    assert said == [None if coloured else False]


def test_a_word_for_a_number_is_said_to_be_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert entry.run(["marker", "seven"]) == 2
    assert "'seven' is not a whole number" in capsys.readouterr().err


def test_a_process_without_descriptors_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _install(monkeypatch, _raise(OSError(errno.EMFILE, "Too many open files")))
    assert entry.run(["plan"]) == 1
    said = capsys.readouterr().err
    assert said == (
        "clearway: error: Too many open files: raise the limit on open files (`ulimit -n 256`)\n"
    )
