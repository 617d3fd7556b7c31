"""Runs the examples of a documentation page, in order, and compares what they print.

- A ``python`` block runs in one namespace a page; a ``console`` block's lines that begin with
  ``$ `` are commands (``clearway ...`` runs in this process, ``cat FILE`` prints a file).
- A ``text`` block right below a ``python`` block is what that printed. In both kinds of output
  ``...`` stands for anything, as in doctest.
- Every other block is for the eye only.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from navigation.cli.main import run

_FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Example:
    """One block: its kind, its text, the output stated for it (None: none), and its line."""

    kind: str
    text: str
    wanted: str | None
    line: int


def examples_in(page: str) -> Iterator[Example]:
    """The blocks of a page that run."""
    found = list(_FENCE.finditer(page))
    for number, fence in enumerate(found):
        line = page.count("\n", 0, fence.start()) + 2
        if fence[1] == "console":
            yield Example("console", fence[2], None, line)
        if fence[1] == "python":
            below = found[number + 1] if number + 1 < len(found) else None
            stated = (
                below is not None
                and below[1] == "text"
                and not page[fence.end() : below.start()].strip()
            )
            yield Example("python", fence[2], below[2] if stated and below else None, line)


def run_page(file: Path) -> int:
    """Run every example of the page in the current folder; how many there were."""
    page = file.read_text(encoding="utf-8")
    namespace: dict[str, object] = {"__name__": file.stem}
    count = 0
    for example in examples_in(page):
        count += 1
        place = f"{file.name}:{example.line}"
        if example.kind == "python":
            # as many lines above as in the page, so that a traceback names the page's line
            code = compile("\n" * (example.line - 1) + example.text, str(file), "exec")
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(code, namespace)
            if example.wanted is not None:
                compare(place, example.wanted, out.getvalue())
        else:
            for command, wanted in commands_in(example.text):
                printed = printed_by(command, place)
                if wanted:
                    compare(f"{place}: {command}", wanted, printed)
    return count


def commands_in(text: str) -> Iterator[tuple[str, str]]:
    """Each command of a console block, and the output below it."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, _, wanted = re.sub(r"\\\n\s*", "", part).partition("\n")
        yield command, wanted


def printed_by(command: str, place: str) -> str:
    """What the command prints on stdout; it has to end well."""
    program, *arguments = shlex.split(command, comments=True)
    if program == "cat":
        return "".join(Path(name).read_text(encoding="utf-8") for name in arguments)
    assert program == "clearway", f"{place}: {command}: only clearway and cat run here"
    with contextlib.redirect_stdout(io.StringIO()) as out:
        code = run(arguments)
    assert code == 0, f"{place}: {command}: exit code {code}"
    return out.getvalue()


def compare(place: str, wanted: str, got: str) -> None:
    """AssertionError that shows both, where the output is not what the page states."""
    rules = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    assert doctest.OutputChecker().check_output(wanted, got, rules), (
        f"{place}: the page states\n{wanted}\nbut it printed\n{got}"
    )
