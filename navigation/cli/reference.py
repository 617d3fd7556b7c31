"""The reference of the commands, made from the parser.

`python -m navigation.cli.reference > docs/reference/commands.md` writes it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import click

from navigation.cli.examples import EXAMPLES
from navigation.cli.main import COMMANDS, clearway

HEAD = """# Commands

Made by `python -m navigation.cli.reference` from what the program accepts.

Every command takes `--help`, and `--debug` for the traceback of an error. Exit codes: 0 done,
2 wrong usage or unreadable input, 3 no path or an unsafe graph, 78 bad configuration, 1 anything
else.

A *SOURCE* is a picture (dark obstacles on light), a scene as text or JSON, a ROS `map_server`
YAML or a MovingAI `.map`. A *CONFIG* is [a configuration](../configuration.md). `X,Y[,DEG]` is a
place in the source's units, with a heading in degrees where that matters."""


def commands_markdown() -> str:
    """The whole page."""
    lines = [HEAD, "", "| command | does |", "|---|---|"]
    lines += [f"| [`{name}`](#{name}) | {listed.help} |" for name, listed in COMMANDS.items()]
    with click.Context(clearway, info_name="clearway") as ctx:
        for name in COMMANDS:
            lines += ["", *_command(ctx, name)]
    return "\n".join(lines) + "\n"


def _command(ctx: click.Context, name: str) -> Iterator[str]:
    command = clearway.get_command(ctx, name)
    assert command is not None
    own = click.Context(command, parent=ctx, info_name=name)
    yield from _described(command, own, "##")
    example = EXAMPLES[name]
    yield from (example.does, "", "```sh", example.line, "```")
    if isinstance(command, click.Group):
        yield ""
        for inner, one in command.commands.items():
            yield from _described(one, click.Context(one, parent=own, info_name=inner), "###")


def _described(command: click.Command, own: click.Context, level: str) -> Iterator[str]:
    usage = " ".join(command.collect_usage_pieces(own))
    name = own.command_path.removeprefix("clearway ")
    yield from (f"{level} {name}", "", f"`clearway {name} {usage}`", "")
    yield from (_markdown(command.help or ""), "")
    rows = list(_options(command, own))
    if rows:
        yield from ("| option | meaning |", "|---|---|", *rows, "")


def _options(command: click.Command, ctx: click.Context) -> Iterator[str]:
    for option in command.get_params(ctx):
        record = option.get_help_record(ctx)
        if isinstance(option, click.Argument) or record is None or "--help" in option.opts:
            continue
        names, meaning = record
        cells = (f"`{_cell(names)}`", _cell(meaning))
        yield f"| {cells[0]} | {cells[1]} |"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _markdown(help_text: str) -> str:
    text = "\n".join(line.strip() for line in help_text.replace("\b", "").splitlines())
    return re.sub(r"(?<![\w`-])(--[a-z][a-z-]*)", r"`\1`", text).strip()


if __name__ == "__main__":
    click.echo(commands_markdown(), nl=False)
