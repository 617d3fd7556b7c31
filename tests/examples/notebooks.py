"""Notebooks, run as a person runs them.

    python -m tests.examples.notebooks [FILE...]

runs all of them, or those named, and keeps their outputs in the file.

Outputs are committed so that a reader sees them without running anything. Whatever changes with the
time or the machine is left out: times of cells, versions, colours of the terminal.
"""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
CELL_S = 800
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def executed(file: Path, folder: Path) -> Any:
    """A notebook with the outputs of a fresh run in ``folder``; raises what a cell raises."""
    book = nbformat.read(file, as_version=4)
    kept = json.loads(json.dumps(book.metadata))
    client = NotebookClient(
        book, timeout=CELL_S, resources={"metadata": {"path": str(folder)}}, record_timing=False
    )
    client.execute()
    book.metadata = nbformat.from_dict(kept)
    return book


def code_cells(book: Any) -> list[Any]:
    """The cells that run."""
    return [cell for cell in book.cells if cell.cell_type == "code"]


def text_of(cell: Any) -> str:
    """All text that a cell puts out; a picture counts by its line of text."""
    texts = [
        output.text if output.output_type == "stream" else output.data.get("text/plain", "")
        for output in cell.outputs
    ]
    return "\n".join(texts)


def kinds_of(cell: Any) -> list[list[str]]:
    """The kinds of a cell's outputs, as MIME types."""
    return [sorted(output.get("data", {"stream": ""})) for output in cell.outputs]


def words_and_numbers(text: str) -> tuple[list[str], list[float]]:
    """A text without its numbers and its spaces, and the numbers."""
    words = NUMBER.sub("#", text).split()
    return words, [float(number) for number in NUMBER.findall(text)]


def main() -> None:
    """Run every notebook and keep its outputs in ``examples/``."""
    os.environ.pop("MPLBACKEND", None)  # pictures go into the notebook
    for file in map(Path, sys.argv[1:] or sorted(EXAMPLES.glob("*.ipynb"))):
        with tempfile.TemporaryDirectory() as folder:
            nbformat.write(executed(file, Path(folder)), file)


if __name__ == "__main__":
    main()
