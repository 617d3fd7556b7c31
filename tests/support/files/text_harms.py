"""Harms to text files: extreme words, lines in another order, brackets thousands deep."""

from __future__ import annotations

import re

import numpy as np

EXTREMES = (
    *("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e400", "0", "-0", "-1", "0x10", "1_000"),
    *("99999999999", "4294967296", "2147483648", "65536x65536", "9" * 400, "\u0663", "\u00e9"),
    *("''", '"', "[", "]", "{", "}", "(", ")", ":", ",", "#", "#@", "~", "null", "true", "\x00"),
    *(
        "..",
        "../x",
        "\\",
        "\ufeff",
        "!!python/object:os.system",
        "&a",
        "*a",
        "<<:",
        "---",
        "[" * 99,
    ),
)


def swap_word(data: bytes, rng: np.random.Generator) -> bytes:
    """A word of a text becomes an extreme, another of its words, or nothing."""
    words = list(re.finditer(rb"[^\s,:\[\]]+", data))
    if not words:
        return data
    chosen = words[int(rng.integers(len(words)))]
    other = words[int(rng.integers(len(words)))].group()
    extreme = EXTREMES[int(rng.integers(len(EXTREMES)))].encode()
    new = (extreme, extreme, other, b"")[int(rng.integers(4))]
    return data[: chosen.start()] + new + data[chosen.end() :]


def move_line(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.splitlines(keepends=True)
    if len(lines) < 2:
        return data
    line = lines.pop(int(rng.integers(len(lines))))
    for _ in range(int(rng.integers(0, 3))):
        lines.insert(int(rng.integers(len(lines) + 1)), line)
    return b"".join(lines)


def nest(data: bytes, rng: np.random.Generator) -> bytes:
    """Brackets thousands deep, where a word was."""
    at = int(rng.integers(0, len(data) + 1))
    return data[:at] + b"[{("[int(rng.integers(3))].to_bytes(1, "big") * 3000 + data[at:]


def break_lines(data: bytes, rng: np.random.Generator) -> bytes:
    new = (b"\r\n", b"\r", b"", b"\n\n", b"\t", b"\x0b", b"\xe2\x80\xa8")
    return data.replace(b"\n", new[int(rng.integers(7))], int(rng.integers(1, 5)))


TEXT_HARMS = (*[swap_word] * 4, *[move_line] * 2, *[break_lines] * 2, nest)
