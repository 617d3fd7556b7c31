"""Catches the lines that picture decoders write to stderr by themselves.

libpng and libjpeg complain past OpenCV and Python: only the file descriptor can catch that. It
belongs to the whole process, so other threads' output is caught too. Hence this is for commands
that decode a picture before they start any thread. Like OpenCV's own lines, they are shown unless
OPENCV_LOG_LEVEL is SILENT.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Iterator
from typing import IO

_MOST_BYTES = 1 << 16
_HARMLESS = ("libpng warning:", "[")
"""libpng warns of data that it repairs or ignores; OpenCV's lines begin with a bracket."""
_PERHAPS = "extraneous bytes before marker"
"""libjpeg skipped bytes: padding that some cameras write, or the end of a damaged scan."""


class DecoderLines:
    """The lines, once the block has ended."""

    def __init__(self) -> None:
        self.lines: tuple[str, ...] = ()

    @property
    def damage(self) -> str:
        """The last complaint about damage, if any."""
        told = [line for line in self.lines if _PERHAPS not in line]
        return told[-1] if told else ""

    @property
    def doubt(self) -> str:
        """The last complaint that may or may not mean damage."""
        told = [line for line in self.lines if _PERHAPS in line]
        return told[-1] if told else ""


@contextlib.contextmanager
def caught_decoder_lines() -> Iterator[DecoderLines]:
    """Hold back the output to stderr's descriptor."""
    said = DecoderLines()
    if sys.stderr is not None:
        sys.stderr.flush()
    with contextlib.ExitStack() as stack:
        try:
            own = os.dup(2)
            stack.callback(os.close, own)
            kept = stack.enter_context(_nameless_file())
        except OSError:  # no stderr, or no space: let the lines pass
            yield said
            return
        os.dup2(kept.fileno(), 2)
        try:
            yield said
        finally:
            os.dup2(own, 2)
            kept.seek(0)
            text = kept.read(_MOST_BYTES)
            if os.environ.get("OPENCV_LOG_LEVEL") != "SILENT":
                os.write(2, text)
            lines = text.decode("utf-8", errors="replace").splitlines()
            plain = (" ".join("".join(c for c in a if c.isprintable()).split()) for a in lines)
            said.lines = tuple(a for a in plain if a and not a.startswith(_HARMLESS))


def _nameless_file() -> IO[bytes]:
    """A file in memory if possible: folders may be read-only."""
    if hasattr(os, "memfd_create"):
        return os.fdopen(os.memfd_create("decoder_lines"), "w+b")
    return tempfile.TemporaryFile()
