"""The manual page ``clearway.1``, made from the parser, in the marks of man(7).

    python -m navigation.cli.man_page > clearway.1

``.ci/compile-wheel`` puts it into ``share/man/man1`` of a wheel.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.metadata import version

import click

from navigation.cli.examples import EXAMPLES
from navigation.cli.main import COMMANDS, clearway

ENVIRONMENT = {
    "CLEARWAY_DEBUG": "Show the traceback of an error, as --debug does.",
    "NUMBA_CACHE_DIR": "Where compiled kernels are kept; beside the sources where it is not set.",
    "NUMBA_CPU_NAME": "The processor that kernels are compiled for.",
    "XDG_RUNTIME_DIR": "Where a running daemon has its control socket, in clearway/control.sock.",
}
EXIT_CODES = {
    "0": "Done.",
    "2": "Wrong usage or unreadable input.",
    "3": "There is no path, or a graph is unsafe.",
    "78": "Bad configuration.",
    "1": "Anything else.",
    "130": "Interrupted by Ctrl-C.",
}


def man_page() -> str:
    """The whole page."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield f'.TH CLEARWAY 1 "" "Clearway {version("clearway")}" "Clearway Manual"'
    sentence = (clearway.help or "").strip().split("\n\n")[0].rstrip(".")
    yield from (".SH NAME", _plain(f"clearway - {sentence}"))
    yield ".SH SYNOPSIS"
    yield r".B clearway"
    yield _plain("[--debug] [--version] [--help] COMMAND [OPTION]... [ARGUMENT]...")
    yield ".SH DESCRIPTION"
    yield _plain(
        "Clearway finds obstacles in the picture of a camera above an arena, builds the roadmap "
        "with the largest clearance, plans on it, and drives a robot along the plan. A SOURCE "
        "is a picture (dark obstacles on light), a scene as text or JSON, a ROS map_server YAML or "
        "a MovingAI .map. A CONFIG is a YAML file that clearway init writes. X,Y[,DEG] is a place "
        "in the source's units, with a heading in degrees where that matters."
    )
    yield ".SH OPTIONS"
    with click.Context(clearway, info_name="clearway") as ctx:
        yield from _options(clearway, ctx)
        yield ".SH COMMANDS"
        for name in COMMANDS:
            yield from _command(ctx, name)
    yield ".SH EXIT STATUS"
    for code, meaning in EXIT_CODES.items():
        yield from (".TP", f".B {code}", _plain(meaning))
    yield ".SH ENVIRONMENT"
    for name, meaning in ENVIRONMENT.items():
        yield from (".TP", f".B {name}", _plain(meaning))
    yield ".SH SEE ALSO"
    yield _plain("clearway COMMAND --help; clearway completion, for your shell.")


def _command(ctx: click.Context, name: str) -> Iterator[str]:
    command = clearway.get_command(ctx, name)
    assert command is not None
    own = click.Context(command, parent=ctx, info_name=name)
    yield from _described(command, own)
    example = EXAMPLES[name]
    yield from (".PP", _plain(f"Example: {example.does}"))
    yield from (".PP", ".RS 4", ".nf", _plain(example.line), ".fi", ".RE")
    if isinstance(command, click.Group):
        for inner, one in command.commands.items():
            yield from _described(one, click.Context(one, parent=own, info_name=inner))


def _described(command: click.Command, own: click.Context) -> Iterator[str]:
    usage = " ".join(command.collect_usage_pieces(own))
    yield f".SS {_escaped(f'{own.command_path} {usage}')}"
    for paragraph in re.split(r"\n\s*\n", (command.help or "").replace("\b", "").strip()):
        yield from (".PP", _plain(paragraph))
    yield from _options(command, own)


def _options(command: click.Command, ctx: click.Context) -> Iterator[str]:
    for option in command.get_params(ctx):
        record = option.get_help_record(ctx)
        of_all = command is not clearway and "--help" in option.opts
        if isinstance(option, click.Argument) or record is None or of_all:
            continue
        names, meaning = record
        if "--help" in option.opts:  # the caller decides which of its names a command has kept
            names = "-h, --help"
        yield from (".TP", f".B {_escaped(names)}", _plain(meaning))


def _plain(text: str) -> str:
    line = _escaped(" ".join(text.split()))
    return rf"\&{line}" if line.startswith((".", "'")) else line


def _escaped(text: str) -> str:
    return text.replace("\\", r"\e").replace("-", r"\-")


if __name__ == "__main__":
    click.echo(man_page(), nl=False)
