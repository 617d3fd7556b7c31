"""A live calibration in a terminal: the picture's parts as a table; elsewhere lines.

Rules
- A part shows its spread in hundredths of a pixel: green if done, yellow if a board was there and
  more are needed, grey if none was. The part with the board's middle is reversed.
- A terminal's display is redrawn in place. Elsewhere there is a line for each view or refusal.
"""

from __future__ import annotations

import math
from typing import Final, TextIO

from rich.console import Console, Group
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from navigation.dashboard.calibrating.said import board_line, cells_line, known_line, wanted_line
from vision.calibrate.live.session import LiveState
from vision.camera.camera import Frame

REDRAWS_HZ: Final = 8
_STEPS: Final = 20
_CELL_WIDE: Final = 6


class TerminalTable:
    """Draws in place on a terminal; a context manager."""

    def __init__(self, console: Console) -> None:
        self._live = Live(console=console, refresh_per_second=REDRAWS_HZ, transient=False)
        self._last_remark = ""

    def __enter__(self) -> TerminalTable:
        self._live.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._live.stop()

    def show(self, state: LiveState, frame: Frame) -> None:
        """Draw the state; the picture is not for terminals."""
        if state.view is not None and state.remark:
            self._last_remark = state.remark
        self._live.update(drawn(state, self._last_remark))


class TerminalLines:
    """Writes a line whenever a view was taken or refused."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._said = ""
        self._asked = False

    def show(self, state: LiveState, frame: Frame) -> None:
        """Write the news."""
        if not self._asked:
            self._asked = True
            self._write(wanted_line(state))
        if state.taken:
            self._write(f"{state.remark}; {cells_line(state)}; {known_line(state)}")
            self._write(wanted_line(state))
        elif "not taken" in state.remark and state.remark != self._said:
            self._write(state.remark)
        self._said = state.remark

    def _write(self, line: str) -> None:
        self._stream.write(line + "\n")
        self._stream.flush()


def drawn(state: LiveState, remark: str) -> Group:
    """The whole display of a state; ``remark`` is the last remark on a view."""
    lines = Text()
    lines.append(_upper(wanted_line(state)), style="bold green" if state.done else "bold")
    lines.append(f"\n\nBoard: {board_line(state)}", style="" if state.view else "yellow")
    lines.append("\n")
    lines.append_text(_stillness(state.still))
    lines.append(f"\n\nViews: {state.count}; {cells_line(state)}")
    lines.append(f"\n{_upper(known_line(state))}")
    lines.append(f"\n{_upper(remark)}", style="dim")
    picture = Panel(_cells(state), title="picture", subtitle="spread in px", expand=False)
    return Group(picture, lines, Text("Ctrl-C ends it with the views taken so far", style="dim"))


def _cells(state: LiveState) -> Table:
    cells = state.cells
    rows, columns = cells.sigma_px.shape
    at = None
    if state.view is not None:
        x, y = state.view.corners_px.mean(axis=0)
        at = int(y * rows / state.size[1]), int(x * columns / state.size[0])
    table = Table.grid(padding=0)
    for _ in range(columns):
        table.add_column(width=_CELL_WIDE, justify="center")
    for row in range(rows):
        words = []
        for column in range(columns):
            sigma = float(cells.sigma_px[row, column])
            style = "black on yellow" if cells.seen[row, column] else "white on grey30"
            if cells.done[row, column]:
                style = "black on green"
            word = _spread(sigma)
            if (row, column) == at:
                word, style = f"[{word}]", f"bold reverse {style}"
            words.append(Text(word.center(_CELL_WIDE - 1) + " ", style=style))
        table.add_row(*words)
    return table


def _spread(sigma_px: float) -> str:
    if not math.isfinite(sigma_px):
        return "?"
    return f"{sigma_px:.2f}" if sigma_px < 10.0 else ">10"


def _stillness(still: float) -> Text:
    full = round(_STEPS * still)
    return Text.assemble(
        "Still: ",
        ("#" * full, "green" if still >= 1.0 else "yellow"),
        ("." * (_STEPS - full), "dim"),
    )


def _upper(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]
