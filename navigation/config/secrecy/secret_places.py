"""Places of secrets in a configuration's source, however it writes them.

Rules
- Readable YAML is searched node by node. The same words elsewhere, and comments that mention a
  secret, are left out too.
- Unreadable text is searched line by line, and rather too much is left out: from a secret key to
  the end of its line, and lines below that are indented deeper or hold the value alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Final

import yaml

from navigation.config.marks import compose
from navigation.config.secrecy.secrets import (
    HIDDEN,
    SECRET_KEY,
    Redactor,
    is_secret_key,
    known,
    secrets_of_address,
)

_KEY_LINE: Final = re.compile(
    rf"{SECRET_KEY.pattern}[\w-]{{0,64}}[\"']?[ \t]{{0,64}}(?:\n[ \t]{{0,64}})?[:=]"
    r"|(?<![\w-])[\w-]{3,64}[\"']?[ \t]{0,64}(?:\n[ \t]{0,64})?[:=]"
)
_NAME: Final = re.compile(r"[\w-]+")
_COMMENT: Final = re.compile(r"(?m)(?:^|[ \t])#[^\n]*")
_NOTHING_YET: Final = re.compile(r"(?:(?:[&!]\S*|[|>][-+0-9]*)(?:\s+|$))*(?:#.*)?$")
"""Text that may follow a key whose value begins on the next line."""
MOST_WORDS: Final = 50
"""A longer value is left out in its place only; its single words are no secrets."""


def secrets_in_source(text: str) -> set[str]:
    """Secret values of a configuration's text, sound or not."""
    root = _root(text)
    if root is None:
        spans = list(_line_by_line(text))
        found = {text[a:b].strip().strip("\"'|>-").strip() for a, b in spans}
        words = {word.strip("\"',{}[]") for a, b in spans for word in _words(text[a:b])}
        return {s for s in found | words if s} | set(secrets_of_address(text))
    found = set()
    for node, is_secret in _scalars(root, under_secret=False, seen=set()):
        if is_secret:
            found |= {node.value, *_words(node.value)}
        found |= set(secrets_of_address(node.value))
    return found


def secrets_in_environment(environment: Mapping[str, str]) -> set[str]:
    """Secret values of variables that override a configuration."""
    found: set[str] = set()
    for name, value in environment.items():
        if name.startswith("CLEARWAY_"):
            found |= secrets_in_source(value)
            if is_secret_key(name.removeprefix("CLEARWAY_")):
                found |= {value, value.strip().strip("\"'")}
    return found


def secret_spans(text: str) -> list[tuple[int, int]]:
    """Places of secrets in the text, in order and without overlap."""
    root = _root(text)
    spans = [] if root is None else list(_node_spans(root))
    if root is None:
        spans += _line_by_line(text)
    comments = (match.span() for match in _COMMENT.finditer(text))
    spans += [(a, b) for a, b in comments if _names_a_secret(text[a:b])]
    spans += Redactor(known().secrets | secrets_in_source(text)).spans(text)
    return _merged(spans)


def masked(text: str, more: Iterable[tuple[int, int]] = ()) -> str:
    """Put a star for each character of a secret and of ``more`` places; lines and columns stay."""
    spans = _merged([*secret_spans(text), *more])
    return _replaced(text, spans, lambda secret: re.sub(r"[^\s]", "*", secret))


def without_secrets(text: str, more: Iterable[tuple[int, int]] = ()) -> str:
    """Text of a configuration without its secrets and the ``more`` places."""
    return _without(text, _merged([*secret_spans(text), *more]))


def log_without_secrets(text: str) -> str:
    """A log or report without learned secrets and values beside secret keys."""
    return _without(text, _merged([*_line_by_line(text), *known().spans(text)]))


def _without(text: str, spans: list[tuple[int, int]]) -> str:
    return _replaced(text, spans, lambda _: HIDDEN)


def _replaced(text: str, spans: list[tuple[int, int]], shown: Callable[[str], str]) -> str:
    parts, end = [], 0
    for start, stop in spans:
        parts += [text[end:start], shown(text[start:stop])]
        end = stop
    return "".join([*parts, text[end:]])


def _words(value: str) -> list[str]:
    words = value.split()
    return words if len(words) <= MOST_WORDS else []


@lru_cache(maxsize=2)  # one text is asked about several times, and reading it takes longest
def _root(text: str) -> yaml.Node | None:
    try:
        root = compose(text)
    except (yaml.YAMLError, RecursionError):
        return None
    return root if isinstance(root, yaml.CollectionNode) else None


def _scalars(
    node: yaml.Node, *, under_secret: bool, seen: set[tuple[int, bool]]
) -> Iterator[tuple[yaml.ScalarNode, bool]]:
    if (id(node), under_secret) in seen:
        return
    seen.add((id(node), under_secret))
    if isinstance(node, yaml.ScalarNode):
        yield node, under_secret
    elif isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _scalars(item, under_secret=under_secret, seen=seen)
    elif isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            named = isinstance(key, yaml.ScalarNode) and is_secret_key(key.value)
            yield from _scalars(value, under_secret=under_secret or named, seen=seen)


def _node_spans(root: yaml.Node) -> Iterator[tuple[int, int]]:
    for node, is_secret in _scalars(root, under_secret=False, seen=set()):
        if is_secret and node.value:
            yield node.start_mark.index, node.end_mark.index


def _line_by_line(text: str) -> Iterator[tuple[int, int]]:
    end = 0
    for match in _KEY_LINE.finditer(text):
        if match.start() < end or not _names_a_secret(match.group()):
            continue
        line_start = text.rfind("\n", 0, match.start()) + 1
        indent = _indent(text[line_start:])
        end = _line_end(text, match.end())
        rest = text[match.end() : end].strip()
        is_open = _NOTHING_YET.fullmatch(rest) is not None
        quote = rest[:1]
        if quote in "\"'" and quote and rest.count(quote) < 2:
            closing = text.find(quote, text.index(quote, match.end()) + 1)
            end = len(text) if closing < 0 else _line_end(text, closing)
        looked = end
        while looked < len(text):
            before, looked = looked, _line_end(text, looked + 1)
            line = text[before + 1 : looked]
            if line.strip() and not is_open and _indent(line) <= indent:
                break
            if line.strip():
                is_open, end = False, looked
        start = match.end()
        while start < end and text[start] in " \t":
            start += 1
        yield start, end
        if rest.startswith("*"):
            name = re.escape(rest[1:].split()[0].strip(",}]"))
            for anchor in re.finditer(rf"&{name}[ \t]+", text):
                yield anchor.end(), _line_end(text, anchor.end())


def _names_a_secret(text: str) -> bool:
    """True if the text mentions a secret or has a key that is one mistyped."""
    if SECRET_KEY.search(text):
        return True
    keys = _KEY_LINE.finditer(text)
    return any(is_secret_key(name[0]) for key in keys if (name := _NAME.match(key[0])))


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _line_end(text: str, start: int) -> int:
    found = text.find("\n", start)
    return len(text) if found < 0 else found


def _merged(spans: list[tuple[int, int]]) -> list[tuple[int, int]]:
    merged: list[tuple[int, int]] = []
    for start, stop in sorted(span for span in spans if span[0] < span[1]):
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(stop, merged[-1][1]))
        else:
            merged.append((start, stop))
    return merged
