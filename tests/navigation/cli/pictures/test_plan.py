"""`clearway plan`, run in this process as the entry point runs it."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from subprocess import PIPE

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from tests.support.pictures import Told
from tests.support.processes.forked import Program

ARENA = """\
#@ clearway.scene/1
#@ units m
#@ bounds given -2 -1 2 1
L 4 (-0.5,-0.6)(-0.5,0.2)(-0.2,0.2)(-0.2,-0.6)
C (0.9,0.1) 0.3
"""
GOOD = ("--start", "-1.5,-0.5", "--goal", "1.5,0.5", "--radius", "0.1")
FIELDS = [
    "schema",
    "status",
    "units",
    "robot_radius",
    "path",
    "length",
    "min_clearance",
    "cost",
    "unrounded",
    "waypoints",
    "duration",
    "speed_limit",
    "alternatives",
    "order",
    "reason",
    "bottleneck",
    "widest_radius",
    "counts",
    "timings_ms",
]
COUNTS = [
    "border_pixels",
    "vertices",
    "generators",
    "voronoi_vertices",
    "roadmap_nodes",
    "roadmap_edges",
]
STAGES = [
    "load",
    "binarise",
    "contours",
    "geometry",
    "voronoi",
    "roadmap",
    "path",
    "trajectory",
    "render",
    "total",
]


@pytest.fixture
def arena(tmp_path: Path) -> Path:
    path = tmp_path / "arena.txt"
    path.write_text(ARENA)
    return path


def strict_json(text: str) -> dict:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def plan(*arguments: object) -> int:
    return run(["plan", *map(str, arguments)])


def clearance(x: float, y: float) -> float:
    box = math.hypot(max(-0.5 - x, 0, x + 0.2), max(-0.6 - y, 0, y - 0.2))
    return min(box, math.hypot(x - 0.9, y - 0.1) - 0.3, x + 2, 2 - x, y + 1, 1 - y)


def test_a_plan_as_json_has_every_field_and_keeps_the_radius(arena, capsys):
    code = plan(
        arena, "--start", "-1.5,-0.5,90", "--goal", "1.5,0.5", "--radius", 0.1, "--format", "json"
    )
    answer = strict_json(capsys.readouterr().out)
    assert code == 0
    assert [k for k in FIELDS if k not in answer] == []
    assert (answer["schema"], answer["status"], answer["units"]) == ("clearway.plan/1", "ok", "m")
    assert answer["path"][0] == [-1.5, -0.5]
    assert answer["path"][-1] == [1.5, 0.5]
    dense = [
        (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))
        for line in (answer["path"], [(w["x"], w["y"]) for w in answer["waypoints"]])
        for a, b in pairwise(line)
        for t in np.linspace(0, 1, 11)
    ]
    assert min(clearance(*p) for p in dense) >= 0.1 - 1e-9
    assert answer["length"] == pytest.approx(
        sum(math.dist(a, b) for a, b in pairwise(answer["path"]))
    )
    along = [
        (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))
        for a, b in pairwise(answer["path"])
        for t in np.linspace(0, 1, 11)
    ]
    sampled = min(clearance(*p) for p in along)
    assert answer["min_clearance"] <= sampled + 1e-9
    gap = answer["bottleneck"]
    assert clearance(gap["x"], gap["y"]) == pytest.approx(answer["min_clearance"])
    assert gap["width"] == pytest.approx(2 * answer["min_clearance"])
    assert answer["waypoints"][0]["heading"] == pytest.approx(math.pi / 2)
    assert answer["waypoints"][-1]["time"] == pytest.approx(answer["duration"])
    times = [w["time"] for w in answer["waypoints"]]
    assert times == sorted(times)
    assert answer["reason"] is None
    assert answer["widest_radius"] is None
    assert list(answer["counts"]) == COUNTS
    assert list(answer["timings_ms"]) == [stage for stage in STAGES if stage != "render"]
    assert answer["counts"]["generators"] > answer["counts"]["vertices"] == 5


def test_a_plan_as_text_says_the_same(arena, capsys):
    assert plan(arena, "--start", "-1.5,-0.5", "--goal=1.5,0.5", "--radius", 0.1) == 0
    out = capsys.readouterr().out
    assert out.startswith("path of length ")
    assert "least clearance " in out
    assert " waypoints, " in out


def test_no_path_is_exit_code_3_with_the_answer_on_stdout(arena, capsys):
    base = (arena, "--start", "-1.5,-0.5", "--goal", "1.5,0.5", "--radius", 0.45)
    assert plan(*base, "--format", "json") == 3
    answer = strict_json(capsys.readouterr().out)
    assert answer["status"] == "unreachable"
    assert answer["reason"]
    nulls = ("path", "length", "min_clearance", "waypoints", "duration", "alternatives", "order")
    assert all(answer[name] is None for name in nulls)
    assert [k for k in FIELDS if k not in answer] == []
    assert plan(*base) == 3
    captured = capsys.readouterr()
    assert captured.err.startswith("clearway: no path for a robot of radius 0.45 m: ")
    assert "no path" not in captured.out


def test_a_picture_that_cannot_be_drawn_leaves_the_answer(arena, tmp_path, capsys):
    request = (*GOOD, "--render", tmp_path / "missing" / "plan.svg")
    assert plan(arena, *request) == 2
    captured = capsys.readouterr()
    assert "missing" in captured.err


def test_stations_are_visited_and_numbered(arena, capsys):
    stations = ("--via", "0.3,-0.5", "--via", "-1,0.8,45")
    code = plan(arena, *GOOD, *stations, "--format", "json")
    answer = strict_json(capsys.readouterr().out)
    assert code == 0
    assert answer["order"] == [0, 1]
    at = [(w["x"], w["y"], round(w["heading"], 6)) for w in answer["waypoints"]]
    assert (-1.0, 0.8, round(math.pi / 4, 6)) in at
    assert (0.3, -0.5) in {(x, y) for x, y, _ in at}


def test_the_answer_goes_to_a_file_and_the_picture_beside_it(arena, tmp_path, capsys):
    out, svg, png = tmp_path / "plan.json", tmp_path / "plan.svg", tmp_path / "plan.PNG"
    base = (arena, "--start", "-1.5,0", "--goal", "1.5,0.5", "--radius", 0.1, "--format", "json")
    assert plan(*base, "-o", out, "--render", svg) == 0
    assert capsys.readouterr().out == ""
    answer = strict_json(out.read_text())
    assert answer["status"] == "ok"
    times = answer["timings_ms"]
    assert times["total"] >= sum(ms for stage, ms in times.items() if ms and stage != "total") - 1
    assert times["render"] > 0
    assert svg.read_text().startswith("<svg")
    assert plan(*base, "--render", png) == 0
    assert cv2.imread(str(png)) is not None


def test_a_plain_file_grows_its_derived_bounds_to_hold_start_and_goal(tmp_path, capsys):
    source = tmp_path / "plain.txt"
    source.write_text("L 4 (0,0)(10,0)(10,10)(0,10)\n")
    assert plan(source, "--start", "-200,5", "--goal", "300,5", "--radius", 2) == 0
    source.write_text("#@ clearway.scene/1\n#@ bounds given -20 -20 30 30\nP (0,0)\n")
    assert plan(source, "--start", "-200,5", "--goal", "20,5", "--radius", 2) == 3


def picture(path: Path) -> Path:
    image = np.full((240, 320), 255, dtype=np.uint8)
    cv2.rectangle(image, (120, 60), (180, 239), 0, -1)
    cv2.circle(image, (240, 100), 25, 0, -1)
    cv2.imwrite(str(path), image)
    return path


def test_a_picture_is_planned_in_its_pixels(tmp_path, capsys):
    source = picture(tmp_path / "arena.png")
    base = (source, "--start", "40,200", "--goal", "280,200", "--radius", 9, "--format", "json")
    assert plan(*base) == 0
    answer = strict_json(capsys.readouterr().out)
    assert answer["units"] == "px"
    assert min(y for _, y in answer["path"]) < 60 - 9
    assert None not in answer["timings_ms"].values()
    assert "render" not in answer["timings_ms"], "nothing was drawn"
    assert answer["counts"]["border_pixels"] > 400
    assert plan(*base, "--polarity", "light") == 3


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("--start", "1", *GOOD[2:]), "must be X,Y or X,Y,DEG"),
        (("--start", "1,2,3,4", *GOOD[2:]), "must be X,Y or X,Y,DEG"),
        (("--start", "nan,2", *GOOD[2:]), "finite"),
        ((*GOOD[:4], "--radius", "0"), "> 0"),
        ((*GOOD[:4], "--radius", "-1"), "> 0"),
        ((*GOOD[:4], "--radius", "nan"), "> 0"),
        ((*GOOD[:4], "--radius", "inf"), "> 0"),
        ((*GOOD, "--margin", "-1"), ">= 0"),
        ((*GOOD, "--spacing", "0.2"), "must be < 2 radius = 0.2"),
        ((*GOOD, "--prefer", "fast"), "clearance, length, balanced"),
        ((*GOOD, "--prefer", "1.5"), "from 0 (length)"),
        ((*GOOD, "--alternatives", "-1"), "alternatives"),
        ((*GOOD, "--order", "any"), "--order"),
        ((*GOOD, "--render", "x.gif"), "must end in .svg or .png"),
        ((*GOOD, "--format", "xml"), "--format"),
        (GOOD[:4], "--radius"),
        ((*GOOD, "--bogus"), "--bogus"),
    ],
)
def test_wrong_usage_is_exit_code_2_and_one_sentence(arena, capsys, arguments, what):
    assert plan(arena, *arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert what in captured.err
    assert captured.err.count("\n") == 1
    assert "Traceback" not in captured.err


@pytest.mark.parametrize(
    ("name", "data", "what"),
    [
        ("none.txt", None, "No such file"),
        ("noise.txt", b"\x00\x01\xff", "not a text file"),
        ("noise.png", b"noise", "not a picture"),
        ("cut.png", b"\x89PNG\r\n\x1a\n", "damaged picture"),
        ("bad.txt", b"L 3 (1,1)", ":1:3: 3 vertices announced"),
        ("bad.yaml", b"image: x.pgm", "'resolution'"),
        ("bad.map", b"type octile\nheight 1\nwidth 2\nmap\n.\n", ":5:1: width 2"),
        ("empty.txt", b"", "no records"),
    ],
)
def test_unreadable_input_is_exit_code_2_and_names_the_file(tmp_path, capsys, name, data, what):
    path = tmp_path / name
    if data is not None:
        path.write_bytes(data)
    assert plan(path, *GOOD) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert str(path) in captured.err
    assert what in captured.err
    assert captured.err.count("\n") == 1


@pytest.mark.parametrize("command", ["plan", "roadmap"])
def test_a_plan_through_a_picture_that_shows_nothing_is_warned_of(tmp_path, capsys, command):
    path = tmp_path / "fog.png"
    assert cv2.imwrite(str(path), np.full((60, 90), 180, np.uint8))
    more = ["--start", "10,10", "--goal", "80,50"]
    more = more if command == "plan" else ["-o", str(tmp_path / "map.graphml")]
    assert run([command, str(path), *more, "--radius", "3"]) == 0
    told = capsys.readouterr()
    assert told.err.startswith(f"clearway: warning: {path}: no obstacle was found in the picture")
    assert told.err.count("\n") == 1
    assert "note: no obstacle was found in the picture" in told.out


@pytest.mark.parametrize("value", [0, 255])
def test_a_picture_of_one_colour_is_answered_without_a_traceback(tmp_path, capsys, value):
    path = tmp_path / "plain.png"
    cv2.imwrite(str(path), np.full((60, 80), value, dtype=np.uint8))
    code = plan(path, "--start", "20,30", "--goal", "60,30", "--radius", 5)
    captured = capsys.readouterr()
    assert code == (2 if value == 0 else 0)
    # why there is no free space, or that nothing was found
    assert captured.err.count("\n") == 1


def test_an_output_that_cannot_be_written_is_exit_code_2(arena, tmp_path, capsys):
    assert plan(arena, *GOOD, "-o", tmp_path / "no" / "plan.txt") == 2
    assert plan(arena, *GOOD, "-o", tmp_path / "plan.txt", "--render", tmp_path / "no/x.svg") == 2


def test_asking_for_help_compiles_nothing():
    code = (
        "import sys, navigation.cli.pictures.plan, navigation.cli.pictures.roadmap;"
        "sys.exit(any(m in sys.modules for m in ('numba', 'cv2', 'networkx', 'numpy')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0


REAL = os.environ.get("CLEARWAY_REAL_DATA")


@pytest.mark.skipif(not REAL, reason="CLEARWAY_REAL_DATA is not set: no real data to plan on")
@pytest.mark.parametrize(
    ("source", "start", "goal", "radius"),
    [
        ("maps/depot.yaml", "3,3", "25,8", 0.2),
        ("maps/tb3_sandbox.yaml", "-2,-0.5", "1,1.8", 0.15),
        ("maps/random-32-32-10.map", "11,6", "7,18", 0.3),
    ],
)
def test_real_maps_are_planned(capsys, source, start, goal, radius):
    request = ("--start", start, "--goal", goal, "--radius", radius, "--format", "json")
    assert plan(Path(str(REAL)) / source, *request) == 0
    answer = strict_json(capsys.readouterr().out)
    a, b = ([float(v) for v in point.split(",")] for point in (start, goal))
    assert math.dist(a, b) <= answer["length"] <= 2 * math.dist(a, b)
    assert answer["min_clearance"] >= radius


@pytest.mark.skipif(not REAL, reason="CLEARWAY_REAL_DATA is not set: no scenarios to compare with")
def test_movingai_paths_are_about_as_long_as_the_scenarios_say(capsys):
    folder = Path(str(REAL)) / "maps"
    lines = (folder / "random-32-32-10-random-1.scen").read_text().splitlines()[1:]
    for line in lines[:40:4]:
        _, _, _, _, x0, y0, x1, y1, optimal = line.split("\t")
        arguments = ("--start", f"{x0},{y0}", "--goal", f"{x1},{y1}", "--radius", 0.3)
        source = folder / "random-32-32-10.map"
        assert plan(source, *arguments, "--prefer", "length", "--format", "json") == 0
        answer = strict_json(capsys.readouterr().out)
        straight = math.dist((float(x0), float(y0)), (float(x1), float(y1)))
        assert straight - 1e-9 <= answer["length"] <= 1.5 * float(optimal) + 2.0


def test_a_search_that_reached_its_limit_is_a_remark(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("planner.search.tangent_search.BUDGET", 1)
    file = tmp_path / "arena.txt"
    file.write_text("#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 10 8\nC (5,4) 1\n")
    ends = ["--start", "2,4", "--goal", "8,4", "--radius", "0.3", "--prefer", "length"]
    assert run(["plan", str(file), *ends, "--format", "json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert any("there may be a shorter one" in remark for remark in answer["remarks"])


def test_a_plan_that_draws_nothing_loads_no_networkx(tmp_path):
    """Loading it takes a good part of a plan's time from a cold start."""
    file = tmp_path / "arena.txt"
    file.write_text("#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 10 8\nC (5,4) 1\n")
    code = (
        "import sys; from navigation.cli.main import run\n"
        f"code = run(['plan', {str(file)!r}, '--start', '2,4', '--goal', '8,4', '--radius', '0.3'])"
        "\nsys.exit(code or 'networkx' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()


@pytest.fixture
def drawn(tmp_path: Path) -> Path:
    """A dark square, and a grey one that only a high level takes for an obstacle."""
    picture = np.full((200, 300), 240, np.uint8)
    picture[60:140, 60:110] = 20
    picture[60:140, 190:240] = 150
    path = tmp_path / "drawn.png"
    cv2.imwrite(str(path), picture)
    return path


def piped(data: bytes, *words: object, cwd: Path | None = None) -> Told:
    """Answer to what comes through a pipe, which holds 64 KiB."""
    end, start = os.pipe()
    os.write(start, data)
    os.close(start)
    program = Program(words, cwd=cwd, stdin=end, stdout=PIPE, stderr=PIPE)
    os.close(end)
    out, err = program.communicate(120)
    return Told(program.wait(), out, err)


@pytest.mark.parametrize("command", ["plan", "roadmap"])
def test_what_is_an_obstacle_is_said_as_for_extract(drawn, tmp_path, capsys, command):
    where = ("--start", "20,20", "--goal", "280,180") if command == "plan" else ()
    counts = {}
    for level in (100, 200):
        out = tmp_path / f"{level}.json"
        words = (command, drawn, *where, "--radius", 5, "-o", out, "--method", "fixed")
        words += ("--format", "json") if command == "plan" else ()
        assert run([str(w) for w in (*words, "--threshold", level)]) == 0
        answer = json.loads(out.read_text())
        counts[level] = answer["counts"]["vertices"] if command == "plan" else len(answer["edges"])
    assert counts[100] < counts[200]
    capsys.readouterr()
    assert run([command, str(drawn), *where, "--radius", "5", "--threshold", "9", "-o", "-"]) == 2
    assert "is for --method fixed only" in capsys.readouterr().err


def test_a_picture_is_read_from_standard_input_and_passed_on(drawn):
    scene = piped(drawn.read_bytes(), "extract", "-", "-o", "-")
    assert scene.code == 0
    assert scene.out.startswith("#@ clearway.scene/1")
    graph = piped(scene.out.encode(), "roadmap", "-", "--radius", 5, "-o", "-")
    assert graph.code == 0, graph.err
    assert json.loads(graph.out)["nodes"]
    assert "nodes, " in graph.err
    words = ("--start", "20,20", "--goal", "280,180", "--radius", 5)
    both = (scene.out.encode(), drawn.read_bytes())
    answers = [piped(data, "plan", "-", *words).out for data in both]
    of_file = piped(b"", "plan", drawn, *words)
    assert answers[0] == answers[1] == of_file.out


def test_the_picture_of_a_piped_ros_map_lies_where_one_is(tmp_path):
    cells = np.full((40, 60), 254, np.uint8)
    cells[10:20, 25:35] = 0
    cv2.imwrite(str(tmp_path / "m.pgm"), cells)
    header = (
        b"image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
        b"occupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    words = ("plan", "-", "--start", "0.5,0.5", "--goal", "5.5,3.5", "--radius", 0.2)
    assert piped(header, *words, cwd=tmp_path).code == 0


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "standard input: "),
        (b"\x89PNG\r\n\x1a\nno picture", "standard input: not a picture, or a damaged picture"),
        (b"P 1 (2,\n", "standard input:1:"),
    ],
)
def test_what_cannot_be_read_from_standard_input_is_one_sentence(data, said):
    words = ("plan", "-", "--start", "1,1", "--goal", "2,2", "--radius", 1)
    ended = piped(data, *words)
    assert ended.code == 2
    assert ended.err.startswith(f"clearway: error: {said}")
    assert ended.err.count("\n") == 1


def test_a_scene_is_not_binarised(arena, capsys):
    assert plan(arena, *GOOD, "--method", "otsu") == 2
    assert "no picture: --method otsu is for pictures only" in capsys.readouterr().err
