"""Output of a run for people: on stdout, or its end on stderr if stdout fails.

A full disk under a redirected stdout, or a vanished reader, costs the lines and never the run.
"""

from __future__ import annotations

import contextlib
import os
import sys

import click


class Voice:
    """Prints lines; never raises. ``trouble`` says why stdout fails."""

    def __init__(self, *, quiet: bool = False) -> None:
        self._quiet = quiet
        self.trouble = "stdout is closed" if sys.stdout is None else ""

    def say(self, line: str) -> None:
        """Print a line of news, unless the run is quiet."""
        if not self._quiet:
            self._say_on_stdout(line)

    def tell(self, line: str) -> None:
        """Print a line that must be read: on stderr if stdout fails."""
        from navigation.config.secrecy.secrets import hide

        if not self._say_on_stdout(hide(line)):
            complain(line)

    def _say_on_stdout(self, line: str) -> bool:
        if self.trouble:
            return False
        try:
            click.echo(line)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else None
            self.trouble = f"stdout cannot be written: {reason or error}"
            _point_at_nothing()
            complain(f"clearway: {self.trouble}; the run continues, and its end is reported here")
            return False
        return True


def complain(line: str) -> None:
    """Print a line on stderr, if possible, without any secret."""
    from navigation.config.secrecy.secrets import (
        hide,
    )

    line = hide(line)
    with contextlib.suppress(OSError, ValueError):  # there is no reader left
        click.echo(line, err=True)


def _point_at_nothing() -> None:
    """Discard stdout's buffer, so that no later flush fails on it."""
    with contextlib.suppress(OSError, ValueError):  # a stdout that is not a file has no descriptor
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
        sys.stdout.flush()
