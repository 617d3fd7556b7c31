"""The instrument that sums the tests' time: two small reports become phases and tables."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.suite import main, read_phase

UNTIMED = """<?xml version="1.0" encoding="utf-8"?>
<testsuites name="pytest tests"><testsuite name="pytest" tests="3" time="4.5">
<testcase classname="tests.planner.path.test_path" name="test_one" time="1.0">
<properties><property name="processor_s" value="3.25"/></properties></testcase>
<testcase classname="tests.planner.path.test_path.TestMore" name="test_two" time="0.5">
<properties><property name="other" value="9"/>
<property name="processor_s" value="0.5"/></properties>
</testcase>
<testcase classname="tests.vision.test_edges" name="test_three[a.b]" time="2.0"/>
</testsuite></testsuites>
"""
TIMED = """<testsuite name="pytest" tests="1" time="7.0">
<testcase classname="tests.system.test_floods" name="test_four" time="6.5">
<properties><property name="processor_s" value="1.0"/></properties></testcase>
</testsuite>
"""


@pytest.fixture
def reports(tmp_path: Path) -> list[Path]:
    """One report with pytest's outer element, and one without."""
    files = [tmp_path / "untimed.xml", tmp_path / "timed.xml"]
    for file, text in zip(files, (UNTIMED, TIMED), strict=True):
        file.write_text(text)
    return files


def test_a_report_is_a_phase_of_its_tests(reports: list[Path]) -> None:
    phase = read_phase(reports[0])
    assert (phase.name, phase.wall_s, phase.processor_s) == ("untimed", 4.5, 3.75)
    assert [(case.file, case.name, case.folder) for case in phase.cases] == [
        ("tests/planner/path/test_path.py", "test_one", "tests/planner/path"),
        ("tests/planner/path/test_path.py", "test_two", "tests/planner/path"),  # of a class
        ("tests/vision/test_edges.py", "test_three[a.b]", "tests/vision"),
    ]
    assert phase.cases[2].processor_s == 0.0, "not measured"


def test_tables_name_what_takes_most_processor_time_first(
    reports: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    main([*map(str, reports), "--shown", "2"])
    lines = [line for line in capsys.readouterr().out.splitlines() if line[:4] != "|---"]
    assert lines == [
        "| phase | tests | processor s | wall s |",
        "| untimed | 3 | 4 | 4 |",
        "| timed | 1 | 1 | 7 |",
        "",
        "| folder | tests | processor s | wall s |",
        "| tests/planner/path | 2 | 3.8 | 1.5 |",
        "| tests/system | 1 | 1.0 | 6.5 |",
        "",
        "| file | tests | processor s | wall s |",
        "| tests/planner/path/test_path.py | 2 | 3.8 | 1.5 |",
        "| tests/system/test_floods.py | 1 | 1.0 | 6.5 |",
        "",
        "| test | tests | processor s | wall s |",
        "| tests/planner/path/test_path.py::test_one | 1 | 3.2 | 1.0 |",
        "| tests/system/test_floods.py::test_four | 1 | 1.0 | 6.5 |",
        "",
    ]
