"""The table of all attacks, as Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence

from benchmarks.adversary.bars import (
    DRIVER_LIMIT_S,
    END_LIMIT_S,
    PERMIT_LIMIT_S,
    SAID_LIMIT_S,
    STOP_LIMIT_S,
    Outcome,
)


def _mm(least_gap_m: float) -> str:
    return "-" if math.isinf(least_gap_m) else f"{least_gap_m * 1e3:.0f}"


def _stop(outcomes: Sequence[Outcome]) -> str:
    times = [outcome.stop_s for outcome in outcomes]
    if any(time is None for time in times):
        return "none"
    return f"{max(time for time in times if time is not None):.2f}"


def _row(kind: str, name: str, outcomes: Sequence[Outcome]) -> str:
    passed = sum(not outcome.failures for outcome in outcomes)
    worst = min(outcomes, key=lambda outcome: (not outcome.failures, outcome.least_gap_m))
    end = f"{worst.state}: {worst.sentence}".replace("|", "/").replace("\n", " ")
    cells = [
        kind,
        name,
        f"{passed}/{len(outcomes)}",
        _mm(min(outcome.least_gap_m for outcome in outcomes)),
        _stop(outcomes),
        f"{max(outcome.drove_s for outcome in outcomes):.2f}",
        f"{max(outcome.blind_m for outcome in outcomes):.2f}",
        end,
    ]
    return f"| {' | '.join(cells)} |"


def table(runs: Sequence[tuple[str, Outcome]], took_s: float, command: str) -> str:
    """``runs``: the attack's kind and what came of each run."""
    failed = [outcome for _, outcome in runs if outcome.failures]
    rows: dict[tuple[str, str], list[Outcome]] = {}
    for kind, outcome in runs:
        rows.setdefault((kind, outcome.attack), []).append(outcome)
    text = [
        "# The standing judge",
        "",
        f"{len(rows)} attacks on the running system, {len(runs)} runs in {took_s / 60:.0f} min:",
        f"{len(runs) - len(failed)} held every bar. Real processes over pseudo-terminals and",
        "Motion JPEG streams; the robot's true place, sampled 200 times a second, decides.",
        "",
        "The bars: the true clearance of the robot's disc is never below 0 (gap); no driving",
        f"later than {PERMIT_LIMIT_S:g} s after the last valid permit, braking left out (drove);",
        f"`stop` is answered within {STOP_LIMIT_S:g} s while the fault lasts (stop); the end is",
        f"said in a sentence, and no robot that stands for {SAID_LIMIT_S:g} s is said to drive. A",
        "permit is valid from when the program sent it, if it came through.",
        f"A robot behind a driver drives for {DRIVER_LIMIT_S:g} s at most, at its speed, after its",
        "driver's last sign of life (drove), and not after it was said to be stopped. A program",
        f"that gets SIGTERM in place of a stop ends within {END_LIMIT_S:g} s (stop) and leaves no",
        "process behind.",
        "Blind is no bar: the way that the robot went while the program took it for elsewhere, by",
        "more than 0.1 m.",
        "",
        f"`{command}` makes this table again.",
        "",
        "| kind | fault | held | gap, mm | stop, s | drove, s | blind, m | how it ended |",
        "|---|---|---|---|---|---|---|---|",
        *[_row(kind, name, outcomes) for (kind, name), outcomes in rows.items()],
    ]
    if failed:
        text += ["", "## Not held", ""]
        text += [f"- {one.attack}, seed {one.seed}: {'; '.join(one.failures)}" for one in failed]
    return "\n".join(text) + "\n"
