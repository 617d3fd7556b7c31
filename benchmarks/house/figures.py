"""Every figure of the house with its limit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from benchmarks.house import counts, documents
from benchmarks.house.imports import circles
from benchmarks.house.tree import ALL, PACKAGES, read

MOST_PARAMETERS = 10
MOST_FUNCTION_LINES = 80
MOST_COMPLEXITY = 15
MOST_FILES = 15
MOST_FILE_LINES = 400
LEAST_FILE_LINES = 40


@dataclass(frozen=True, slots=True)
class Figure:
    """What is counted, what was found, and how much of it there may be; ``None``: any number."""

    name: str
    found: tuple[str, ...]
    most: int | None = 0

    @property
    def holds(self) -> bool:
        return self.most is None or len(self.found) <= self.most


def figures(root: Path) -> list[Figure]:
    """Count everything below a root; needs ruff, which ``make install-dev`` brings."""
    files = read(root, ALL)
    shipped = [file for file in files if file.package in PACKAGES]
    found = {
        f"kernels with more than {MOST_PARAMETERS} parameters": counts.wide_kernels(
            shipped, MOST_PARAMETERS
        ),
        f"functions over {MOST_FUNCTION_LINES} lines": counts.long_functions(
            files, MOST_FUNCTION_LINES
        ),
        f"functions of complexity above {MOST_COMPLEXITY} without a reason": (
            counts.complex_functions(root, PACKAGES, MOST_COMPLEXITY)
        ),
        f"folders above {MOST_FILES} Python files": counts.crowded_folders(files, MOST_FILES),
        f"files above {MOST_FILE_LINES} lines": counts.long_files(files, MOST_FILE_LINES),
        "source files named by no document": documents.unnamed(shipped, documents.texts(root)),
        "import circles between folders": circles(shipped),
    }
    short = counts.short_kernel_files(shipped, LEAST_FILE_LINES)
    return [
        *(Figure(name, tuple(sentences)) for name, sentences in found.items()),
        Figure(f"kernel files under {LEAST_FILE_LINES} lines", tuple(short), None),
    ]
