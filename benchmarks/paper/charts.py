"""Charts: dots with straight lines on plain axes, and dots on logarithmic ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.paper import canvas
from navigation.draw.shapes import (
    FAINT_INK,
    FLOOR,
    FRAME,
    INK,
    Area,
    Colour,
    DiscShape,
    Label,
    Strokes,
)

WIDTH, HEIGHT = 270.0, 260.0
Dots = Sequence[tuple[float, float]]
Place = Callable[[float, float], tuple[float, float]]
Ticks = Sequence[tuple[float, str]]


@dataclass(frozen=True, slots=True)
class Fit:
    """A straight line through dots, and the exponent of a power through them."""

    slope: float
    intercept: float
    exponent: float


def fit(x: Sequence[float], y: Sequence[float]) -> Fit:
    """Least squares, plain for the line and in logarithms for the power."""
    slope, intercept = np.polyfit(x, y, 1)
    exponent, _ = np.polyfit(np.log(x), np.log(y), 1)
    return Fit(float(slope), float(intercept), float(exponent))


@dataclass(frozen=True, slots=True)
class Chart:
    """One chart on a page, its frame's corner at ``left``, ``top``."""

    page: canvas.Page
    left: float
    top: float
    title: str
    x_name: str
    y_name: str

    def plain(self, full: Dots, reduced: Dots) -> None:
        """Both ways' dots and their straight lines; from zero on both axes."""
        x_step, y_step = _step(max(x for x, _ in full)), _step(max(y for _, y in full))
        x_max = x_step * math.ceil(max(x for x, _ in full) / x_step)
        y_max = y_step * math.ceil(max(y for _, y in full) / y_step)

        def at(x: float, y: float) -> tuple[float, float]:
            return self.left + WIDTH * x / x_max, self.top + HEIGHT * (1.0 - y / y_max)

        xs = [i * x_step for i in range(round(x_max / x_step) + 1)]
        ys = [i * y_step for i in range(round(y_max / y_step) + 1)]
        self._grid([(at(x, 0.0)[0], f"{x:g}") for x in xs], [(at(0.0, y)[1], f"{y:g}") for y in ys])
        # a line that meets the axis to the right of zero leaves room above the few dots only
        crosses = fit([x for x, _ in full], [y for _, y in full]).intercept < 0.0
        for dots, colour in ((full, canvas.FULL), (reduced, canvas.REDUCED)):
            line = fit([x for x, _ in dots], [y for _, y in dots])
            x1 = max(x for x, _ in dots)
            x0 = min(max(0.0, -line.intercept / line.slope), x1)
            ends = [at(x, line.slope * x + line.intercept) for x in (x0, x1)]
            self._dots(dots, ends, at, colour)
            each = f"{line.slope * 1e3:.2g} us" if line.slope < 1.0 else f"{line.slope:.3g} ms"
            x, y = ends[1]
            if x > self.left + 0.6 * WIDTH:
                place = (x - 12.0, y + 4.0, "end")
            elif crosses:
                place = (max(x - 24.0, self.left + 4.0), y - 16.0, "start")
            else:
                place = (x + 10.0, y + 4.0, "start")
            self.page.shapes.append(
                Label(*place[:2], f"{each} each", 11.5, colour, place[2], halo=True)
            )

    def logarithmic(self, lines: Sequence[tuple[Dots, Colour]]) -> None:
        """Dots joined by lines, both axes logarithmic."""
        every = [dot for dots, _ in lines for dot in dots]
        first = math.floor(math.log10(min(x for x, _ in every)) + 0.01)
        last = math.ceil(math.log10(max(x for x, _ in every)) - 0.01)
        low = math.floor(math.log10(min(y for _, y in every)) + 0.01)
        high = math.ceil(math.log10(max(y for _, y in every)) - 0.01)

        def at(x: float, y: float) -> tuple[float, float]:
            return (
                self.left + WIDTH * (math.log10(x) - first) / (last - first),
                self.top + HEIGHT * (1.0 - (math.log10(y) - low) / (high - low)),
            )

        every_other = max(1, round((high - low) / 7))
        self._grid(
            [(at(10.0**e, 1.0)[0], _power(e)) for e in range(first, last + 1)],
            [(at(10.0**first, 10.0**e)[1], _power(e)) for e in range(low, high + 1, every_other)],
        )
        for dots, colour in lines:
            self._dots(dots, [at(x, y) for x, y in dots], at, colour)

    def _dots(self, dots: Dots, line: Dots, at: Place, colour: Colour) -> None:
        self.page.shapes.append(Strokes((np.array(line, dtype=np.float64),), colour, 1.6, 0.7))
        self.page.shapes.extend(DiscShape(*at(x, y), radius=3.4, fill=colour) for x, y in dots)

    def _grid(self, xs: Ticks, ys: Ticks) -> None:
        left, right = self.left, self.left + WIDTH
        top, bottom = self.top, self.top + HEIGHT
        box = np.array([(left, top), (right, top), (right, bottom), (left, bottom)])
        lines = [np.array([(x, top), (x, bottom)]) for x, _ in xs]
        lines += [np.array([(left, y), (right, y)]) for y, _ in ys]
        self.page.shapes += [
            Area((box,), FLOOR),
            Label(left, top - 14.0, self.title, 13.0, INK, bold=True),
            Strokes(tuple(lines), FRAME, 0.6, 0.35),
            *(Label(x, bottom + 16.0, t, 10.5, FAINT_INK, "middle") for x, t in xs),
            *(Label(left - 6.0, y + 3.5, t, 10.5, FAINT_INK, "end") for y, t in ys),
            Label(left + 4.0, top + 14.0, self.y_name, 11.0, FAINT_INK),
            Label(left + WIDTH / 2.0, bottom + 34.0, self.x_name, 11.0, FAINT_INK, "middle"),
        ]


def key(page: canvas.Page, y: float, *entries: tuple[float, Colour, str]) -> None:
    """What the colours mean: the left end, the colour and the words of each."""
    for x, colour, text in entries:
        page.shapes += [DiscShape(x, y, 4.0, fill=colour), Label(x + 9.0, y + 4.0, text, 11.5, INK)]


def _step(most: float) -> float:
    """A round step that gives four to eight of them."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(s * power for s in (0.1, 0.2, 0.5, 1.0, 2.0) if most / (s * power) <= 8.0)


def _power(exponent: int) -> str:
    return f"{10.0**exponent:g}" if -3 < exponent < 4 else f"1e{exponent}"
