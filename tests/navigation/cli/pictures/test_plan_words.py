"""What `clearway plan` says: each thing once, with its unit, and what a path was chosen by."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.formats.scene_io import load_scene
from planner.motion.smooth import round_corners
from planner.roadmap.roadmap import build_roadmap
from planner.shared.figures import sized
from tests.navigation.cli.pictures.test_plan import ARENA, plan, strict_json


@pytest.fixture
def arena(tmp_path: Path) -> Path:
    path = tmp_path / "arena.txt"
    path.write_text(ARENA)
    return path


def test_no_path_is_said_once_and_stays_in_a_file(arena, tmp_path, capsys):
    base = (arena, "--start", "-0.3,0", "--goal", "1.5,0.5", "--radius", 0.1)
    assert plan(*base) == 3
    captured = capsys.readouterr()
    assert (captured.out + captured.err).count("no path") == 1
    assert plan(*base, "-o", tmp_path / "plan.txt") == 3
    assert (tmp_path / "plan.txt").read_text().startswith("no path for a robot of radius 0.1 m: ")


def test_the_answer_says_what_the_path_was_chosen_by_and_what_rounding_changed(arena, capsys):
    request = (arena, "--start", "-1.5,-0.5", "--goal", "1.5,-0.5", "--radius", 0.1)
    assert plan(*request, "--alternatives", 2, "--format", "json") == 0
    answer = strict_json(capsys.readouterr().out)
    planned = build_roadmap(load_scene(arena), 0.1).plan((-1.5, -0.5), (1.5, -0.5), alternatives=2)
    assert answer["unrounded"]["length"] == pytest.approx(planned.length)
    assert answer["unrounded"]["min_clearance"] == pytest.approx(planned.min_clearance)
    assert answer["length"] != answer["unrounded"]["length"]
    assert answer["cost"] == pytest.approx(planned.cost)
    costs = [other["cost"] for other in answer["alternatives"]]
    assert costs == pytest.approx([other.cost for other in planned.alternatives])
    assert plan(*request, "--alternatives", 2) == 0
    text = capsys.readouterr().out
    assert f"cost {sized(planned.cost, 'm')}: length {sized(planned.length, 'm')}, narrow" in text
    assert "planned path, before its corners are rounded: length 3" in text
    assert f"alternative 1: cost {sized(costs[0], 'm')}, length " in text


@pytest.mark.parametrize("prefer", ["clearance", "balanced", "length", 0.25])
@pytest.mark.parametrize("margin", [0.0, 0.03])
def test_python_and_the_command_line_have_one_clearance_for_each_path(
    arena, capsys, prefer, margin
):
    ends = (-1.5, -0.5), (1.5, 0.5)
    words = (arena, "--start", "-1.5,-0.5", "--goal", "1.5,0.5", "--radius", 0.1)
    options = ("--prefer", prefer, "--margin", margin, "--alternatives", 1)
    assert plan(*words, *options, "--format", "json") == 0
    answer = strict_json(capsys.readouterr().out)
    roadmap = build_roadmap(load_scene(arena), 0.1)
    planned = roadmap.plan(*ends, prefer=prefer, margin=margin, alternatives=1)
    rounded = round_corners(planned, roadmap, prefer=prefer, margin=margin)
    assert answer["unrounded"]["min_clearance"] == planned.min_clearance
    assert answer["min_clearance"] == rounded.min_clearance
    assert answer["min_clearance"] == roadmap.path_clearance(answer["path"]).distance
    assert answer["path"] == rounded.points.tolist()
    others = [other["min_clearance"] for other in answer["alternatives"]]
    assert others == [other.min_clearance for other in rounded.alternatives]
    assert plan(*words, *options) == 0
    text = capsys.readouterr().out
    assert f"\nleast clearance {sized(rounded.min_clearance, 'm')} at " in text
    (line,) = (line for line in text.splitlines() if line.startswith("planned path, "))
    least = sized(planned.min_clearance, "m", beside=rounded.min_clearance)
    assert line.endswith(f", least clearance {least}")
    assert f"least clearance {planned.min_clearance:.6g} m>" in repr(planned)


def test_headings_are_printed_as_they_are_given_with_every_unit(arena, capsys):
    request = (arena, "--start", "-1.5,-0.5,90", "--goal", "1.5,0.5", "--radius", 0.1)
    assert plan(*request) == 0
    lines = capsys.readouterr().out.splitlines()
    (head,) = (k for k, line in enumerate(lines) if "heading" in line)
    assert " ".join(lines[head].split()) == "x m y m heading deg speed m/s time s"
    assert lines[head + 1].split() == ["-1.5", "-0.5", "90.00", "0", "0.000"]
    assert lines[head - 1].startswith("at 0.2 m/s at most, two radii a second: ")
