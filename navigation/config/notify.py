"""The section `notify`: a command or an address that is called when a mission has ended."""

from __future__ import annotations

import re
from typing import Annotated, Final
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field

from navigation.config.values import Positive, Section, Text

PLACEHOLDERS: Final = ("state", "robot", "sentence", "time")
"""In a command's arguments, in braces; also the keys of the JSON in a POST."""
PLACEHOLDER: Final = re.compile(r"\{([A-Za-z_]+)\}")
"""A word in braces; other braces, as of JSON, are the argument's own."""


def _known_placeholders(argument: str) -> str:
    for word in PLACEHOLDER.findall(argument):
        if word not in PLACEHOLDERS:
            *names, last = (f"{{{name}}}" for name in PLACEHOLDERS)
            raise ValueError(f"'{{{word}}}' must be {', '.join(names)} or {last}")
    if "\0" in argument:
        raise ValueError("must not have a zero byte")
    return argument


def _web_address(address: str) -> str:
    """An address that can be posted to; its text is a secret, and in no message."""
    try:
        parts = urlsplit(address)
        is_one = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        is_one = False
    if not is_one or not address.isascii() or not address.isprintable() or " " in address:
        raise ValueError("must be the whole address of a web page, with http or https and a host")
    if "@" in parts.netloc:
        raise ValueError("must not have a user or password; a key may be in its path or query")
    return address


class NotifySection(Section):
    """Word to people elsewhere: once when a robot's mission is done, stopped or failed."""

    command: (
        Annotated[
            tuple[Annotated[Text, AfterValidator(_known_placeholders)], ...],
            Field(min_length=1, max_length=100),
        ]
        | None
    ) = Field(
        default=None,
        description="program and its arguments, run without a shell; `{state}`, `{robot}`, "
        "`{sentence}` and `{time}` in them are replaced",
    )
    url: Annotated[Text, Field(max_length=2000), AfterValidator(_web_address)] | None = Field(
        default=None,
        description="instead of a command: an http:// or https:// address that gets a POST with "
        "state, robot, sentence and time as JSON",
    )
    within_s: Annotated[Positive, Field(le=60)] = Field(
        default=10.0, description="a call that takes longer is ended, and the log says so"
    )
