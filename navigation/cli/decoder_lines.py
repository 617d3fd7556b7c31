"""What the decoders of pictures write to stderr by themselves, caught.

libpng and libjpeg write their complaints straight to the process's stderr, past OpenCV and past
Python: the only place to catch them is the file descriptor. It belongs to the whole process, so
what another thread writes meanwhile is caught too; hence this is for commands that decode a
picture before they start any thread, and the cameras of a run leave the descriptor alone.

As OpenCV's own lines, they are shown where OPENCV_LOG_LEVEL is not SILENT (``--debug``).
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
"""libpng's warnings are of what it mends or leaves out; OpenCV's lines begin with a bracket."""
_PERHAPS = "extraneous bytes before marker"
"""libjpeg skipped bytes: padding that some cameras write, or the end of a damaged scan."""


class DecoderLines:
    """The lines, once the block of ``caught_decoder_lines`` has ended."""

    def __init__(self) -> None:
        self.lines: tuple[str, ...] = ()

    @property
    def damage(self) -> str:
        """The last complaint that says the picture is not what it was; empty where none does."""
        told = [line for line in self.lines if _PERHAPS not in line]
        return told[-1] if told else ""

    @property
    def doubt(self) -> str:
        """A complaint that may mean damage or nothing; empty where there is none."""
        told = [line for line in self.lines if _PERHAPS in line]
        return told[-1] if told else ""


@contextlib.contextmanager
def caught_decoder_lines() -> Iterator[DecoderLines]:
    """Within the block, what is written to stderr's descriptor is kept back."""
    said = DecoderLines()
    if sys.stderr is not None:
        sys.stderr.flush()
    with contextlib.ExitStack() as stack:
        try:
            own = os.dup(2)
            stack.callback(os.close, own)
            kept = stack.enter_context(_nameless_file())
        except OSError:  # no stderr, or no room to keep it: the lines go where they go
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
    """In memory where there is such a thing: folders may be read-only."""
    if hasattr(os, "memfd_create"):
        return os.fdopen(os.memfd_create("decoder_lines"), "w+b")
    return tempfile.TemporaryFile()
