"""`--least-area`, `--least-branch`: what is left out is said, and nothing that drives can ask."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import cv2
import networkx as nx
import numpy as np
import pytest

import planner
from navigation.cli.main import run
from navigation.config import Config

ROOT = Path(__file__).parents[4]
SPECKS = ((30, 40), (30, 41), (60, 50), (80, 120))
"""Cells of noise, in three specks; the largest has two."""


@pytest.fixture
def noisy(tmp_path: Path) -> Path:
    """The sample map of rooms, with specks; metres, cells of 0.05 m."""
    clean = planner.sample("rooms")
    shutil.copy(clean, tmp_path / "noisy.yaml")
    cells = cv2.imread(str(clean.with_name("rooms.pgm")), cv2.IMREAD_GRAYSCALE)
    for row, column in SPECKS:
        assert cells[row - 1 : row + 2, column - 1 : column + 2].min() > 200
    for row, column in SPECKS:
        cells[row, column] = 0
    cv2.imwrite(str(tmp_path / "rooms.pgm"), cells)
    return tmp_path / "noisy.yaml"


def graph_of(file: Path) -> nx.Graph:
    return nx.node_link_graph(json.loads(file.read_text()), edges="edges")


def test_a_roadmap_without_the_specks_is_that_of_the_clean_map(noisy, tmp_path, capsys):
    graphs = {}
    for name, source, more in (
        ("clean", planner.sample("rooms"), ()),
        ("noisy", noisy, ()),
        ("cleaned", noisy, ("--least-area", "0.006")),
    ):
        out = tmp_path / f"{name}.json"
        assert run(["roadmap", str(source), "--radius", "0.22", "-o", str(out), *more]) == 0
        graphs[name] = graph_of(out)
    said = capsys.readouterr().out
    assert said.count("left out") == 1
    assert (
        "note: left out 3 obstacles smaller than 0.006 square m, the largest of 0.005 square m at "
        "(0.05, 1.98): paths may cross them" in said
    )
    assert nx.utils.graphs_equal(graphs["clean"], graphs["cleaned"])
    assert graphs["noisy"].number_of_edges() > graphs["clean"].number_of_edges()


def test_a_plan_crosses_what_was_left_out_and_says_so(noisy, tmp_path, capsys):
    x, y = -2.0 + 0.05 * 50.5, 3.5 - 0.05 * 60.5
    ends = ["--radius", "0.22", f"--start={x},{y - 0.8}", f"--goal={x},{y + 0.8}"]
    options = [*ends, "--prefer", "length", "--format", "json"]
    answers = {}
    for least in (None, "0.002", "0.003"):
        more = [] if least is None else ["--least-area", least]
        assert run(["plan", str(noisy), *options, *more]) == 0
        answers[least] = json.loads(capsys.readouterr().out)
    assert answers["0.002"]["path"] == answers[None]["path"]
    assert (
        "no obstacle is smaller than 0.002 square m: none was left out"
        in answers["0.002"]["remarks"]
    )
    assert answers["0.003"]["length"] == pytest.approx(1.6)
    assert answers["0.003"]["length"] < answers[None]["length"]
    assert any(r.startswith("left out 2 obstacles") for r in answers["0.003"]["remarks"])
    assert not any("left out" in r for r in answers[None]["remarks"])


def test_short_dead_ends_are_counted(noisy, tmp_path, capsys):
    edges = []
    for more in ((), ("--least-branch", "1")):
        out = tmp_path / "r.json"
        map_file = str(planner.sample("rooms"))
        assert run(["roadmap", map_file, "--radius", "0.22", "-o", str(out), *more]) == 0
        edges.append(graph_of(out).number_of_edges())
    said = capsys.readouterr().out
    (line,) = [line for line in said.splitlines() if "dead end" in line]
    assert re.fullmatch(
        r"note: left out 1 dead end of the roadmap shorter than 1 m: the longest has 0\.\d+ m", line
    )
    assert edges[1] < edges[0]


def test_extract_counts_where_the_answer_is_not_seen(tmp_path, capsys):
    picture = np.full((60, 90), 255, np.uint8)
    picture[10:30, 10:40] = 0
    picture[40, 60] = picture[50, 20] = picture[50, 21] = 0
    cv2.imwrite(str(tmp_path / "arena.png"), picture)
    for least, kept, sentence in (
        (
            3,
            1,
            "left out 2 obstacles smaller than 3 square px, the largest of 2 square px at (20.5",
        ),
        (
            2,
            2,
            "left out 1 obstacle smaller than 2 square px, the largest of 1 square px at (60, 40)",
        ),
        (1, 3, "no obstacle is smaller than 1 square px: none was left out"),
    ):
        out = tmp_path / "scene.txt"
        words = ["extract", str(tmp_path / "arena.png"), "--least-area", str(least), "-o", str(out)]
        assert run(words) == 0
        assert len(planner.load_scene(out).objects) == kept
        assert sentence in capsys.readouterr().err
        assert sentence in out.read_text()


@pytest.mark.parametrize(
    "words",
    [
        ["plan", "m.yaml", "--radius", "1", "--start", "0,0", "--goal", "1,1", "--least-area", "0"],
        ["roadmap", "m.yaml", "--radius", "1", "-o", "r.json", "--least-area", "nan"],
        ["extract", "a.png", "--least-area", "-3"],
        ["roadmap", "m.yaml", "--radius", "1", "-o", "r.json", "--least-branch", "-1"],
    ],
)
def test_no_other_number_is_taken(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(words) == 2
    assert "must be a finite number >" in capsys.readouterr().err


def test_nothing_that_drives_can_leave_out_an_obstacle(capsys):
    for command in ("run", "demo", "sweep", "check", "fleet", "robot"):
        assert run([command, "--help"]) == 0
    assert "--least" not in capsys.readouterr().out
    assert "least_area" not in json.dumps(Config.model_json_schema())
    assert "least_branch" not in json.dumps(Config.model_json_schema())
    asking = {
        file.relative_to(ROOT).as_posix()
        for folder in ("navigation", "vision", "clearway")
        for file in (ROOT / folder).rglob("*.py")
        if re.search(r"[.]without_specks|scene[.]specks|least_branch", file.read_text())
    }
    assert asking == {
        f"navigation/cli/pictures/{name}.py" for name in ("extract", "plan", "roadmap", "sources")
    }
