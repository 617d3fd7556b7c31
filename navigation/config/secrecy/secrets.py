"""What no outgoing text may show: tokens, and the user and password in addresses.

Rules
- Whatever configuration this process reads, sound or broken, `learn` is told its secrets; from
  then on `hide` leaves them out of every sentence, log, page message, report and recording, in
  each form in which they can stand there: as they are, percent-encoded, escaped as in JSON.
- The user's part of any address, every value in its query (with a name or without one) and its
  fragment are left out too, whether they were learned or not; so is what looks like a key in a
  query without its address.
- A value of fewer than ``LEAST_LENGTH`` characters is left out in addresses and beside its key
  only: it would take half the words of every sentence with it.
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

SECRET_KEY: Final = re.compile(r"(?i)(token|passw|pwd|passphrase|secret|api_?key|credential)")
"""What a key looks like whose value is shown to nobody."""
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
    """Leaves secrets out of texts. Never changes; any thread may use it."""

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
        """Plain data, as JSON takes it, with every text in it without its secrets."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, dict):
            return {key: self.plain(inner) for key, inner in value.items()}
        if isinstance(value, list | tuple):
            return [self.plain(inner) for inner in value]
        return value

    def spans(self, text: str) -> Iterator[tuple[int, int]]:
        """Where in the text secrets stand."""
        if self._pattern is not None:
            yield from (match.span() for match in self._pattern.finditer(text))
        yield from ((m.end(1), m.end() - 1) for m in _ADDRESS.finditer(text))
        yield from ((m.end(1), m.end()) for m in _QUERY.finditer(text))
        if "://" in text:
            for address in _QUERY_OF_ADDRESS.finditer(text):
                yield from _values_in(text, address.start(2), address.end(2))
            yield from ((m.end(1), m.end()) for m in _FRAGMENT_OF_ADDRESS.finditer(text))

    def occurs_in(self, data: bytes) -> bool:
        """Whether a secret stands in bytes that cannot be changed, a recording's."""
        return any(secret.encode() in data for secret in self.secrets)


@lru_cache(maxsize=4096)
def is_secret_key(key: str) -> bool:
    """True if what is under this key is shown to nobody: a secret's name, mistyped or not."""
    if SECRET_KEY.search(key):
        return True
    words = {key.lower(), *re.split(r"[_\-]+", key.lower())}
    return any(
        difflib.get_close_matches(word, SECRET_WORDS, n=1, cutoff=NEARNESS)
        for word in words.difference(OTHER_WORDS)
    )


def _without_values(address: re.Match[str]) -> str:
    """An address with the names in its query only: any value may be a key."""
    query, shown, end = address[2], address[1], 0
    for start, stop in _values_in(query, 0, len(query)):
        shown, end = shown + query[end:start] + HIDDEN, stop
    return shown + query[end:]


def _values_in(text: str, start: int, stop: int) -> Iterator[tuple[int, int]]:
    """The values in a query, from ``start`` to ``stop``; a part without a name is one."""
    for part in _PART.finditer(text, start, stop):
        name, _, value = part[0].partition("=")
        is_named = value.strip("=") != ""  # else it is the padding of base64
        yield part.start() + (len(name) + 1 if is_named else 0), part.end()


def _any_form(secret: str) -> str:
    """A pattern for the secret however its characters are encoded, each for itself."""
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
    """The user's part of an address, its password, and the keys in its query, as they are meant."""
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
    """The secrets in plain data: what stands under secret keys, and those of addresses."""
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
    """From now on `hide` leaves these out too; what was learned is never forgotten."""
    global _known  # one process, one set of secrets: texts go out in many places
    with _lock:
        fresh = frozenset(s for s in secrets if len(s) >= LEAST_LENGTH) - _known.secrets
        if fresh:
            _known = Redactor(_known.secrets | fresh)


def known() -> Redactor:
    """What leaves out everything that was learned so far."""
    return _known


def hide(text: str) -> str:
    """The text without any secret that was learned."""
    return _known.text(text)


def hide_in(value: Any) -> Any:
    """Plain data without any secret that was learned."""
    return _known.plain(value)
