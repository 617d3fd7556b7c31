"""Secrets that no outgoing text may show: tokens, and the user and password in addresses.

Rules
- `learn` gets the secrets of any configuration this process reads, sound or broken. From then on
  `hide` leaves them out of every sentence, log, page message, report and recording, in each form:
  plain, percent-encoded, escaped as in JSON, in base64.
- An address's user part, every value in its query and its fragment are left out too, learned or
  not; so is anything like a key in a query without its address.
- A value under ``LEAST_LENGTH`` characters is left out only in addresses and beside its key:
  elsewhere it would take half the words of every sentence with it.
"""

from __future__ import annotations

import base64
import difflib
import json
import re
import threading
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any, Final
from urllib.parse import unquote

SECRET_KEY: Final = re.compile(
    r"(?i)(token|passw|pwd|passphrase|secret|api_?key|credential|(?<![a-z])url(?![a-z]))"
)
"""Key whose value is never shown. The path of an address that is called (`notify.url`) is usually
the key to it."""
SECRET_WORDS: Final = (
    *("token", "password", "passphrase", "secret"),
    *("apikey", "credential", "credentials"),
)
NEARNESS: Final = 0.8
"""A word as near to one of these, by difflib's ratio, is one of them mistyped: `tokn`, `tokne`."""
OTHER_WORDS: Final = ("taken", "secure")
"""Near to them, and words of their own."""
HIDDEN: Final = "(left out)"
LEAST_LENGTH: Final = 4
LONGEST_IN_EVERY_FORM: Final = 500
"""No password is longer; a longer value is found as it is only."""

_ADDRESS: Final = re.compile(
    r"""(://)(?:[^\s/?\#"'<>]{0,500}@"""
    r"""|[^\s/:@"'<>]{0,500}:(?!\d{0,9}(?:[/?\#\s"']|$))[^\s"'<>]{0,500}@)"""
)
"""An address up to its last @; a password with a slash that should have been %2F included."""
_QUERY: Final = re.compile(
    r"""(?i)([?&;](?:pwd|pass\w*|[\w-]*token|api_?key|key|secret|auth\w*|sig\w*)=)"""
    r"""(?:\(left\ out\)|[^&;\s\#"'<>])+"""
)
_FRAGMENT_OF_ADDRESS: Final = re.compile(
    r"""(://(?:\(left\ out\)|[^\s\#"'<>]){0,1000}\#)(?:\(left\ out\)|[^\s"'<>])+"""
)
_QUERY_OF_ADDRESS: Final = re.compile(
    r"""(://(?:\(left\ out\)@)?[^\s?\#"'<>]{0,500}\?)((?:\(left\ out\)|[^\s\#"'<>])+)"""
)
_PART: Final = re.compile(r"[^&;]+")


class Redactor:
    """Immutable filter that leaves secrets out of texts; any thread may use it."""

    def __init__(self, secrets: Iterable[str] = ()) -> None:
        self.secrets = frozenset(s for s in secrets if len(s) >= LEAST_LENGTH)
        longest_first = sorted(self.secrets, key=lambda s: (-len(s), s))
        forms = [_any_form(secret) for secret in longest_first]
        self._pattern = re.compile("|".join(forms)) if forms else None

    def text(self, text: str) -> str:
        """The text without its secrets."""
        if self._pattern is not None:
            text = self._pattern.sub(HIDDEN, text)
        if "://" in text:
            text = _ADDRESS.sub(rf"\1{HIDDEN}@", text)
            text = _QUERY_OF_ADDRESS.sub(_without_values, text)
            text = _FRAGMENT_OF_ADDRESS.sub(rf"\1{HIDDEN}", text)
        return _QUERY.sub(rf"\1{HIDDEN}", text) if "=" in text else text

    def plain(self, value: Any) -> Any:
        """Plain JSON data without its secrets."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, dict):
            return {key: self.plain(inner) for key, inner in value.items()}
        if isinstance(value, list | tuple):
            return [self.plain(inner) for inner in value]
        return value

    def spans(self, text: str) -> Iterator[tuple[int, int]]:
        """Yield the places of secrets."""
        if self._pattern is not None:
            yield from (match.span() for match in self._pattern.finditer(text))
        yield from ((m.end(1), m.end() - 1) for m in _ADDRESS.finditer(text))
        yield from ((m.end(1), m.end()) for m in _QUERY.finditer(text))
        if "://" in text:
            for address in _QUERY_OF_ADDRESS.finditer(text):
                yield from _values_in(text, address.start(2), address.end(2))
            yield from ((m.end(1), m.end()) for m in _FRAGMENT_OF_ADDRESS.finditer(text))

    def occurs_in(self, data: bytes) -> bool:
        """True if bytes that cannot be changed, a recording's, contain a secret."""
        return any(secret.encode() in data for secret in self.secrets)


@lru_cache(maxsize=4096)
def is_secret_key(key: str) -> bool:
    """True if no one may see this key's value: a secret's name, mistyped or not."""
    if SECRET_KEY.search(key):
        return True
    words = {key.lower(), *re.split(r"[_\-]+", key.lower())}
    return any(
        difflib.get_close_matches(word, SECRET_WORDS, n=1, cutoff=NEARNESS)
        for word in words.difference(OTHER_WORDS)
    )


def _without_values(address: re.Match[str]) -> str:
    """An address with only the names in its query: any value may be a key."""
    query, shown, end = address[2], address[1], 0
    for start, stop in _values_in(query, 0, len(query)):
        shown, end = shown + query[end:start] + HIDDEN, stop
    return shown + query[end:]


def _values_in(text: str, start: int, stop: int) -> Iterator[tuple[int, int]]:
    """Yield the values in a query; a part without a name is one."""
    for part in _PART.finditer(text, start, stop):
        name, _, value = part[0].partition("=")
        is_named = value.strip("=") != ""  # else it is the padding of base64
        yield part.start() + (len(name) + 1 if is_named else 0), part.end()


def _any_form(secret: str) -> str:
    """A pattern for the secret in any encoding, chosen for each character."""
    basic = base64.b64encode(secret.encode()).decode()
    if len(secret) > LONGEST_IN_EVERY_FORM:
        return re.escape(secret)
    parts = []
    for letter in re.findall(r"\s+|\S", secret):
        percent = "".join(f"%{byte:02x}" for byte in letter.encode())
        escaped = {json.dumps(letter)[1:-1], repr(letter)[1:-1], letter}
        words = [re.escape(word) for word in sorted(escaped, key=len, reverse=True)]
        if letter.isspace():
            words += [r"\+", r"\s+"]
        parts.append(f"(?:{'|'.join(words)}|(?i:{percent}))")
    return f"(?:{''.join(parts)}|{re.escape(basic)})"


def secrets_of_address(text: str) -> Iterator[str]:
    """Yield an address's user part, password and query keys, raw and decoded."""
    if "://" not in text:
        return
    for match in _ADDRESS.finditer(text):
        user_part = match.group()[3:-1]
        yield from _decoded(user_part)
        name, mark, password = user_part.partition(":")
        yield from _decoded(password if mark else name)
    for match in _QUERY.finditer(text):
        yield from _decoded(match.group()[len(match.group(1)) :])


def _decoded(text: str) -> Iterator[str]:
    yield text
    yield unquote(text)


def secrets_of_data(data: Any, *, under_secret: bool = False) -> Iterator[str]:
    """Yield the secrets in plain data: values under secret keys, and those of addresses."""
    if isinstance(data, dict):
        for key, value in data.items():
            is_secret = under_secret or is_secret_key(str(key))
            yield from secrets_of_data(value, under_secret=is_secret)
    elif isinstance(data, list | tuple):
        for value in data:
            yield from secrets_of_data(value, under_secret=under_secret)
    elif under_secret and data is not None and not isinstance(data, bool):
        yield str(data)
    elif isinstance(data, str):
        yield from secrets_of_address(data)


_lock = threading.Lock()
_known = Redactor()


def learn(secrets: Iterable[str]) -> None:
    """Make `hide` leave these out from now on; nothing learned is forgotten."""
    global _known  # one process, one set of secrets: texts leave in many places
    with _lock:
        fresh = frozenset(s for s in secrets if len(s) >= LEAST_LENGTH) - _known.secrets
        if fresh:
            _known = Redactor(_known.secrets | fresh)


def known() -> Redactor:
    """Filter of everything learned so far."""
    return _known


def hide(text: str) -> str:
    """The text without any learned secret."""
    return _known.text(text)


def hide_in(value: Any) -> Any:
    """Plain data without any learned secret."""
    return _known.plain(value)
