"""What a run says to people: on stdout, and where that takes no more, its end on stderr.

A full disk under a redirected stdout, or a reader that went away, costs the lines and never the
run: that is said once on stderr, and what must be read in any case, the summary, goes there.
"""

from __future__ import annotations

import contextlib
import os
import sys

import click


class Voice:
    """Says lines; never raises. ``trouble`` is why stdout takes no more; empty while it does."""

    def __init__(self, *, quiet: bool = False) -> None:
        self._quiet = quiet
        self.trouble = "stdout is closed" if sys.stdout is None else ""

    def say(self, line: str) -> None:
        """A line of news; left out where the run is quiet."""
        if not self._quiet:
            self._say_on_stdout(line)

    def tell(self, line: str) -> None:
        """A line that must be read: on stderr where stdout takes no more."""
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
    """A line on stderr, if that can be, without any secret."""
    from navigation.config.secrecy.secrets import hide  # only those who say something need it

    line = hide(line)
    with contextlib.suppress(OSError, ValueError):  # nobody is left who could be told
        click.echo(line, err=True)


def _point_at_nothing() -> None:
    """Let what stdout still holds back go nowhere, so that no later flush fails on it."""
    with contextlib.suppress(OSError, ValueError):  # a stdout that is no file has no such thing
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
        sys.stdout.flush()
