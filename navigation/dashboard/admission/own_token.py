"""The program's own token if the configuration has none, kept for the next start.

The file is the user's alone (mode 0600), in the control socket's folder, which is too: anyone who
can read it could give orders over the socket as well.
"""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Final

FORM: Final = re.compile(r"[A-Za-z0-9_-]{32}")


def token_of_run(file: Path, say: Callable[[str], None]) -> str:
    """The kept token; if ``file`` cannot be used, one for this run, and ``say`` gets why."""
    try:
        return own_token(file)
    except OSError as error:
        reason = error.strerror or error
        say(f"the page's token holds for this run only: {file}: {reason}")
        return new_token()


def own_token(file: Path) -> str:
    """Token kept in ``file``, or a new one if that is missing or not ours alone; ``OSError``."""
    kept = _read(file)
    if kept is not None:
        return kept
    token = new_token()
    fresh = file.with_name(f"{file.name}.{os.getpid()}")
    with contextlib.suppress(FileNotFoundError):
        fresh.unlink()
    number = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    with os.fdopen(number, "w", encoding="ascii") as stream:
        stream.write(token + "\n")
    fresh.replace(file)
    return token


def new_token() -> str:
    """A token that cannot be guessed."""
    return secrets.token_urlsafe(24)


def _read(file: Path) -> str | None:
    """Token in the file; None if others could have read or written it."""
    try:
        number = os.open(file, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return None
    with os.fdopen(number, "rb") as stream:
        info = os.fstat(stream.fileno())
        if not stat.S_ISREG(info.st_mode) or info.st_uid != os.getuid() or info.st_mode & 0o077:
            return None
        text = stream.read(100).decode("ascii", "replace").strip()
    return text if FORM.fullmatch(text) else None
