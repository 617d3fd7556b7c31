"""`clearway completion`: a script for a shell."""

from __future__ import annotations

import click

SHELLS = ("bash", "zsh", "fish")


@click.command(short_help="Shell completion for bash, zsh or fish.")
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> None:
    """Print the completion script for SHELL: bash, zsh or fish.

    Load it from the shell's own start file; `docs/how_to/completion.md` has the line for each.
    The script asks `clearway` itself, so that it is never out of date.
    """
    from click.shell_completion import get_completion_class

    from navigation.cli.main import clearway

    kind = get_completion_class(shell)
    assert kind is not None, shell
    click.echo(kind(clearway, {}, "clearway", "_CLEARWAY_COMPLETE").source(), nl=False)
