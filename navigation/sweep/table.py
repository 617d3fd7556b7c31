"""The rows of a sweep as a file, and their summary.

The file is CSV, or Parquet if pyarrow is installed. Rows are appended as they come, so an
interrupted sweep keeps them; at the end the file is rewritten in the order of the runs.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from navigation.sweep.runs import COLUMNS, Row
from navigation.sweep.variations import SweepError

MEASURES: Final = (
    "duration_s",
    "least_gap_m",
    "min_clearance_m",
    "tracking_rms_m",
    "tracking_max_m",
    "goal_error_m",
    "goal_error_deg",
)
"""Columns of the summary."""


class SweepFile:
    """Output file for rows, as a context manager; ``SweepError`` if it cannot be written."""

    def __init__(self, path: Path, columns: Sequence[str] = COLUMNS) -> None:
        self.path, self.columns = path, columns
        self.rows: list[Row] = []
        if path.suffix not in (".csv", ".parquet"):
            raise SweepError(f"{path}: must end in .csv or .parquet")
        if path.suffix == ".parquet":
            _pyarrow()
        # Parquet rows cannot be appended: they wait in a CSV file beside it
        self._growing = path if path.suffix == ".csv" else path.with_suffix(".part.csv")
        try:
            self._file = self._growing.open("w", newline="", encoding="utf-8")
        except OSError as error:
            raise SweepError(f"{self._growing}: {error.strerror or error}") from None
        self._writer = csv.DictWriter(self._file, columns)
        self._writer.writeheader()

    def __enter__(self) -> SweepFile:
        return self

    def add(self, row: Row) -> None:
        """Write a row immediately."""
        self.rows.append(row)
        self._writer.writerow(_as_written(row, self.columns))
        self._file.flush()

    def __exit__(self, _kind: object, error: object, _trace: object) -> None:
        self._file.close()
        if error is None:
            self.rows.sort(key=lambda row: row.run)
            write_rows(self.path, self.rows, self.columns)
            if self._growing != self.path:
                self._growing.unlink()


def _as_written(row: Row, columns: Sequence[str]) -> dict[str, Any]:
    values = asdict(row)
    return {name: values[name] for name in columns}


def write_rows(path: Path, rows: Sequence[Row], columns: Sequence[str] = COLUMNS) -> None:
    """Write all rows, or nothing."""
    fresh = path.with_suffix(path.suffix + ".new")
    if path.suffix == ".parquet":
        arrow = _pyarrow()
        table = arrow.Table.from_pylist([_as_written(row, columns) for row in rows])
        import pyarrow.parquet

        pyarrow.parquet.write_table(table, fresh)
    else:
        with fresh.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            writer.writerows(_as_written(row, columns) for row in rows)
    fresh.replace(path)


def _pyarrow() -> Any:
    try:
        import pyarrow
    except ImportError:
        raise SweepError("a .parquet file needs pyarrow: pip install pyarrow") from None
    return pyarrow


@dataclass(frozen=True, slots=True)
class Spread:
    """Spread of a measure over the runs that have it."""

    count: int
    least: float
    median: float
    p95: float
    most: float


@dataclass(frozen=True, slots=True)
class Summary:
    """Summary of a sweep: number of runs, number of rows by outcome (one row per robot and run),
    and the measures."""

    runs: int
    states: dict[str, int]
    measures: dict[str, Spread]


def summarise_rows(rows: Iterable[Row]) -> Summary:
    """Summarise rows, whatever their order."""
    rows = sorted(rows, key=lambda row: row.run)
    measures = {}
    for name in MEASURES:
        values = np.array([v for row in rows if (v := getattr(row, name)) is not None])
        if len(values):
            least, median, p95, most = np.percentile(values, [0.0, 50.0, 95.0, 100.0])
            measures[name] = Spread(
                len(values), float(least), float(median), float(p95), float(most)
            )
    states = Counter(row.state for row in rows)
    return Summary(len({row.run for row in rows}), dict(sorted(states.items())), measures)
