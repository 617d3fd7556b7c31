"""Puts a changed configuration back into its file, over the text that was changed and no other."""

from __future__ import annotations

from pathlib import Path

from navigation.config.load import read_source
from navigation.shared.whole_file import write_whole


class ChangedMeanwhileError(ValueError):
    """Error: somebody else has changed the file since its text was read."""


def write_source(file: Path, text: str, *, over: str) -> None:
    """Replace the text ``over`` of a configuration; its line ends stay, CR LF where all are.

    ``ChangedMeanwhileError`` if the file has another text by now, OSError, UnwrittenFileError.
    """
    if read_source(file) != over:
        raise ChangedMeanwhileError(f"{file.name} was changed by someone else since")
    raw = file.read_bytes()
    has_cr_lf = b"\r\n" in raw and raw.count(b"\n") == raw.count(b"\r\n")
    write_whole(file, text.replace("\n", "\r\n") if has_cr_lf else text, durable=True)
