"""The entry point ``clearway``: finds the command, runs it, turns errors into exit codes.

Rules
- A command is imported when called, so that ``clearway --help`` needs only click.
- Errors are one sentence on stderr, ``clearway: error: what, where, the limit``; a traceback needs
  ``--debug`` (anywhere on the line) or CLEARWAY_DEBUG.
- Exit codes: 0 done; 2 wrong usage or unreadable input; 3 no path, or an unsafe graph; 78 bad
  configuration; 1 anything else, or what a command returns. Ctrl-C gives 130 and a vanished
  reader 141, both without a word.
"""

from __future__ import annotations

import atexit
import contextlib
import difflib
import errno
import gc
import os
import sys
import threading
import traceback
from collections.abc import Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import NamedTuple

import click

from navigation.cli.examples import epilog
from navigation.cli.voice import complain
from navigation.orders.table import ORDERS
from navigation.shared.garbage import postpone_collection

DONE, FAILED, BAD_INPUT, NO_PATH, BAD_CONFIGURATION = 0, 1, 2, 3, 78
INTERRUPTED = 128 + 2
"""Exit code that a shell reports for SIGINT."""
READER_GONE = 128 + 13
"""Exit code that a shell reports for SIGPIPE."""
NO_ROOM = frozenset((errno.ENOSPC, errno.EDQUOT, errno.EFBIG))
NO_DESCRIPTOR = frozenset((errno.EMFILE, errno.ENFILE))
FFMPEG_ERRORS, FFMPEG_QUIET = "16", "-8"
"""FFmpeg's AV_LOG_ERROR and AV_LOG_QUIET."""

FIRST_ANSWER = """\
Clearway: one camera above an arena, a roadmap with the largest clearance, robots that follow it.
  clearway demo               a simulated arena and its page, no file needed
  clearway plan PICTURE ...   one plan through a picture, scene or map
  clearway run CONFIG.yaml    drive the robot
  clearway --help             all commands"""

OUR_PACKAGES = ("vision", "planner", "navigation", "firmware_protocol")


class ListedCommand(NamedTuple):
    """A command's summary, and the place of it or of a mapping that has it by its name."""

    where: str
    help: str


COMMANDS: dict[str, ListedCommand] = {
    "demo": ListedCommand(
        ".running.demo:command", "A simulated arena and its dashboard, no file needed."
    ),
    "sample": ListedCommand(".setup.sample:command", "A picture or a map to try things with."),
    "run": ListedCommand(".running.run:command", "Drive the robot: camera, planning, serial link."),
    "extract": ListedCommand(".pictures.extract:command", "The geometric structure of a picture."),
    "plan": ListedCommand(".pictures.plan:command", "One plan through a picture, scene or map."),
    "fleet": ListedCommand(
        ".pictures.fleet:command", "Paths for several robots, none of which touch."
    ),
    "roadmap": ListedCommand(".pictures.roadmap:command", "The AGVD roadmap as a file."),
    "audit": ListedCommand(".pictures.audit:command", "What is wrong with a route graph."),
    "markers": ListedCommand(".pictures.markers:command", "The markers in a picture."),
    "robot": ListedCommand(".running.robot:command", "A simulated robot on a serial port."),
    **{
        name: ListedCommand(".running.orders:commands", order.summary)
        for name, order in ORDERS.items()
        if not order.command
    },
    "zone": ListedCommand(".running.zones:command", "The zones of the running daemon."),
    "check": ListedCommand(".setup.check:command", "Check a configuration; report every error."),
    "calibrate": ListedCommand(".setup.calibrate:command", "Calibrate a camera from pictures."),
    "reanchor": ListedCommand(".setup.reanchor:command", ORDERS["reanchor"].summary),
    "marker": ListedCommand(".setup.marker:command", "A robot marker or a board to print."),
    "devices": ListedCommand(".setup.devices:command", "The serial ports and cameras here."),
    "camera": ListedCommand(".setup.camera:command", "What a camera can do, and what it delivers."),
    "doctor": ListedCommand(".setup.doctor:command", "Whether this machine is fit for a run."),
    "dashboard": ListedCommand(
        ".running.dashboard:command", "A recording on the page, to look at."
    ),
    "replay": ListedCommand(
        ".running.replay:command", "Re-run vision and planning on a recording."
    ),
    "sweep": ListedCommand(".running.sweep:command", "Repeat a simulated run with varied errors."),
    "install-service": ListedCommand(
        ".setup.install_service:command", "A systemd unit and a udev rule for a run."
    ),
    "init": ListedCommand(".setup.init_config:command", "Write a commented configuration."),
    "schema": ListedCommand(".setup.schema:command", "The configuration's JSON Schema."),
    "completion": ListedCommand(
        ".setup.completion:command", "Shell completion for bash, zsh or fish."
    ),
}

NEED_LINUX = frozenset(
    ("demo", "run", "robot", "devices", "doctor", "dashboard", "install-service", "zone", *ORDERS)
)
"""Commands that only refuse on other systems, but for their help."""

LOAD_KERNELS = frozenset(("demo", "run", "extract", "plan", "fleet", "roadmap", "audit"))
"""Commands that import much and then answer once, or drive after they have resumed the garbage
collection."""


class LazyGroup(click.Group):
    """A group whose commands are listed in `COMMANDS` and imported on call."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """List the names in the order of use."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the command; None without such a name."""
        listed = COMMANDS.get(cmd_name)
        if listed is None:
            return None
        module, attribute = listed.where.split(":")
        command = getattr(import_module(module, "navigation.cli"), attribute)
        if isinstance(command, Mapping):
            command = command[cmd_name]
        if not isinstance(command, click.Command):
            raise TypeError(f"{listed.where} is not a click command")
        command.epilog = epilog(cmd_name)
        if cmd_name in NEED_LINUX and sys.platform != "linux":
            command.callback = partial(_refuse, cmd_name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command, or suggest a similar one."""
        name = args[0]
        if name in COMMANDS or name.startswith("-"):
            return super().resolve_command(ctx, args)
        near = difflib.get_close_matches(name, COMMANDS, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"the commands are {', '.join(COMMANDS)}"
        raise click.UsageError(f"no command '{name}': {hint}", ctx)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the table without importing a command."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, listed.help) for name, listed in COMMANDS.items()])


def _refuse(name: str, **_arguments: object) -> None:
    from navigation.shared.system import require_linux

    require_linux(name)


def _show_version(ctx: click.Context, _param: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from importlib.metadata import version

        click.echo(f"clearway {version('clearway')}")
        ctx.exit()


@click.group(
    cls=LazyGroup,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 done, 2 wrong usage or unreadable input, 3 no path or an unsafe "
    "graph, 78 bad configuration, 1 anything else.\n\n" + epilog("demo"),
)
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_show_version,
    help="Show the version and exit.",
)
@click.pass_context
def clearway(ctx: click.Context, debug: bool) -> None:
    """One camera above an arena, a roadmap with the largest clearance, a robot that follows it."""
    if ctx.invoked_subcommand is None:
        click.echo(FIRST_ANSWER, err=True)
        ctx.exit(BAD_INPUT)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with one of the module's codes."""
    if arguments is None and LOAD_KERNELS.intersection(sys.argv[1:2]):
        postpone_collection()
    _take_the_first_three()
    threading.excepthook = _tell_a_thread_s_end
    code = run(sys.argv[1:] if arguments is None else arguments)
    if arguments is None:
        _end_process(code)
    sys.exit(code)


def _tell_a_thread_s_end(end: threading.ExceptHookArgs) -> None:
    """Report a thread's end as Python does, without any secret."""
    trace = traceback.format_exception(end.exc_type, end.exc_value, end.exc_traceback)
    name = "a thread" if end.thread is None else f"thread {end.thread.name}"
    complain(f"clearway: {name} has ended:\n{''.join(trace).rstrip()}")


def _take_the_first_three() -> None:
    """Open stdin, stdout and stderr if closed, or the next opened file would become one of them.

    A library's output on stderr would go to the robot if that file were the serial port.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(number, True)
    os.close(number)


def _end_process(code: int) -> None:
    """End at once if nothing is left to wait for; taking the interpreter apart takes 0.1 s.

    Exit handlers still run and all output is written. Returns if other threads still run.
    """
    # another search of all imports for cycles takes 0.3 s
    gc.freeze()
    main_thread = threading.main_thread()
    if any(t is not main_thread and not t.daemon for t in threading.enumerate()):
        return
    atexit._run_exitfuncs()  # `os._exit` runs none, and atexit has no public name for it
    for stream in (sys.stdout, sys.stderr):
        if stream is None:
            continue
        with contextlib.suppress(OSError, ValueError):  # closed: there is no reader
            stream.flush()
    os._exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return its exit code; only a bug here raises."""
    arguments, debug = _take_debug(list(arguments))
    if arguments[:1] == ["help"]:
        arguments = [*arguments[1:], "--help"]
    os.environ.setdefault("OPENCV_LOG_LEVEL", "INFO" if debug else "SILENT")
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", FFMPEG_ERRORS if debug else FFMPEG_QUIET)
    try:
        code = _invoke(arguments)
        if sys.stdout is not None:
            sys.stdout.flush()
    except (click.Abort, KeyboardInterrupt):
        return INTERRUPTED
    except BrokenPipeError:
        return _reader_gone()
    except Exception as error:  # noqa: BLE001 - the last frame: told in one sentence, never lost
        if debug:
            complain(traceback.format_exc().rstrip())
        complain(f"clearway: error: {_sentence(error)}")
        return exit_code_of(error)
    return code if isinstance(code, int) else DONE


def _invoke(arguments: list[str]) -> object:
    """Return value of the command, or the code it exited with.

    click's own ``main`` is only for shell completion: it answers a closed pipe itself.
    """
    if "_CLEARWAY_COMPLETE" in os.environ:
        return clearway.main(args=arguments, prog_name="clearway", standalone_mode=False)
    try:
        with clearway.make_context("clearway", arguments, color=_colour()) as ctx:
            return clearway.invoke(ctx)
    except click.exceptions.Exit as done:
        return done.exit_code


def _colour() -> bool | None:
    """False if colours are unwanted (no-color.org) or unknown; None as click decides."""
    return False if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" else None


def exit_code_of(error: BaseException) -> int:
    """Exit code for an error that ended a command, by whose fault it is.

    An error class may carry its own ``exit_code``. Our own ValueErrors and OSErrors, and the
    system's errors about a file, are the input's fault.
    """
    own = getattr(error, "exit_code", None)
    if isinstance(own, int):
        return own
    if _is_ours(error) and isinstance(error, ValueError | OSError):
        return BAD_INPUT
    if isinstance(error, OSError) and error.filename is not None:
        return BAD_INPUT
    return FAILED


def _sentence(error: Exception) -> str:
    match error:
        case click.UsageError():
            path = error.ctx.command_path if error.ctx else "clearway"
            message = error.format_message().rstrip(".")
            message = message.replace("not a valid integer range", "not a whole number")
            return f"{message} (see '{path} --help')"
        case click.ClickException():
            return error.format_message()
        case OSError() if error.filename is not None and not _is_ours(error):
            return f"{error.filename}: {error.strerror or error}"
        case OSError() if error.errno in NO_ROOM:
            return f"the answer cannot be written: {error.strerror}"
        case OSError() if error.errno in NO_DESCRIPTOR:
            return f"{error.strerror}: raise the limit on open files (`ulimit -n 256`)"
    text = str(error)
    if _is_ours(error) and text:
        return text
    return f"unexpected {type(error).__name__}: {text} (--debug shows where)"


def _is_ours(error: BaseException) -> bool:
    return type(error).__module__.split(".")[0] in OUR_PACKAGES


def _take_debug(arguments: list[str]) -> tuple[list[str], bool]:
    """Accept ``--debug`` behind the command too, where people type it."""
    end = arguments.index("--") if "--" in arguments else len(arguments)
    options = [a for a in arguments[:end] if a != "--debug"]
    asked = len(options) < end or os.environ.get("CLEARWAY_DEBUG", "") not in ("", "0")
    return options + arguments[end:], asked


def _reader_gone() -> int:
    """Point stdout at nothing, so that the interpreter's last flush stays quiet too."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
    return READER_GONE
