"""A pytest plugin: every picture that a test extracts goes before the judge of outlines, too.

Run ``python -m pytest -p tests.support.drawn.judged tests/vision``: at its end it says how many
records were judged, and names the tests with records that do not stand for their borders. Only
pictures in pixels and in mode exact are judged, and none whose pixels are left out by ``ignore``.
"""

from __future__ import annotations

import functools
from collections import Counter
from typing import Any

import pytest

from planner.scene import Scene

_counts: Counter[str] = Counter()
_found: list[str] = []
_running = [""]


def pytest_configure(config: pytest.Config) -> None:
    """Put the judge behind ``vision.extract`` before any test module takes it."""
    import vision
    from vision import pipeline

    plain = pipeline.extract

    @functools.wraps(plain)
    def judged(image: Any, **options: Any) -> Scene:
        scene = plain(image, **options)
        if options.get("mode", "exact") == "exact" and not options.keys() & {
            "calibration",
            "ignore",
        }:
            _judge(image, scene, options)
        return scene

    pipeline.extract = judged
    vision.__dict__["extract"] = judged


def _judge(image: Any, scene: Scene, options: dict[str, Any]) -> None:
    from tests.support.drawn.outline_judge import judge, mask_of

    told = {k: v for k, v in options.items() if k in ("polarity", "method", "threshold")}
    try:
        verdicts = judge(mask_of(image, **told), scene)
    except AssertionError as error:
        _found.append(f"{_running[0]}: {error}")
        return
    _counts["pictures"] += 1
    _counts["records"] += len(verdicts)
    _found.extend(f"{_running[0]}: {one}" for one in verdicts if one.fails())


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Remember which test runs."""
    _running[0] = item.nodeid


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say what was judged."""
    terminalreporter.write_line(
        f"{_counts['records']} records of {_counts['pictures']} pictures judged: "
        f"{len(_found)} do not stand for their borders"
    )
    for one in _found:
        terminalreporter.write_line(f"  {one}")
