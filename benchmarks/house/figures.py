"""Every figure of the house with its limit."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.house import counts
from benchmarks.house.constants import NamedNumber, named_numbers
from benchmarks.house.tree import ALL, PACKAGES, File, read

MOST_FUNCTION_LINES = 80
MOST_FILES = 15
MOST_FILE_LINES = 400
LEAST_FILE_LINES = 40
TUNED = ("vision/outline/", "vision/binarise/")
"""Where numbers have been tuned most: each has its source."""


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
    """Count everything below a root."""
    files = read(root, ALL)
    shipped = [file for file in files if file.package in PACKAGES]
    found = {
        f"functions over {MOST_FUNCTION_LINES} lines": counts.long_functions(
            files, MOST_FUNCTION_LINES
        ),
        f"folders above {MOST_FILES} Python files": counts.crowded_folders(files, MOST_FILES),
        f"files above {MOST_FILE_LINES} lines": counts.long_files(files, MOST_FILE_LINES),
    }
    numbers = list(named_numbers(file for file in shipped if str(file.path).startswith(TUNED)))
    found["named numbers of outlines and binarisation without a source"] = [
        str(one) for one in unsourced(shipped)
    ]
    uncounted = {
        "named numbers of outlines and binarisation": numbers,
        "of these measured or chosen": [one for one in numbers if one.tuned],
    }
    short = counts.short_kernel_files(shipped, LEAST_FILE_LINES)
    return [
        *(Figure(name, tuple(sentences)) for name, sentences in found.items()),
        *(Figure(name, tuple(map(str, some)), None) for name, some in uncounted.items()),
        Figure(f"kernel files under {LEAST_FILE_LINES} lines", tuple(short), None),
    ]


def unsourced(files: Iterable[File]) -> list[NamedNumber]:
    """The named numbers without a source in the folders where each has one."""
    some = (file for file in files if str(file.path).startswith(TUNED))
    return [one for one in named_numbers(some) if not one.source]
