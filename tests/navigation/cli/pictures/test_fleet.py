"""`clearway fleet`, run in this process as the entry point runs it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from navigation.draw.driven import colour_of
from tests.support.oracles.fleet_judge import least_gap

ARENA = """\
#@ clearway.scene/1
#@ units m
#@ bounds given -2 -1 2 1
L 4 (-0.5,-0.6)(-0.5,0.2)(-0.2,0.2)(-0.2,-0.6)
C (0.9,0.1) 0.3
"""
ROBOTS = """\
name, start_x, start_y, goal_x, goal_y, radius
ada, -1.5, -0.5, 1.5, 0.5, 0.1
bob, 1.5, 0.5, -1.5, -0.5, 0.1
eve, -1.5, 0.5, 1.5, -0.5, 0.08
"""
FIELDS = [
    "schema", "status", "units", "robots", "dependencies", "makespan_s", "flowtime_s", "reason",
    "blocking", "proved", "timings_ms", "remarks",
]  # fmt: skip


@pytest.fixture
def arena(tmp_path: Path) -> Path:
    path = tmp_path / "arena.scene"
    path.write_text(ARENA)
    return path


def robots_file(folder: Path, text: str, name: str = "robots.csv") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def asked(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = run(["fleet", *map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out, err


def test_json_holds_a_track_for_each_robot(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    robots = robots_file(tmp_path, ROBOTS)
    code, out, err = asked(capsys, arena, "--robots", robots, "--format", "json")
    assert (code, err) == (0, "")
    answer = json.loads(out)
    assert list(answer) == FIELDS
    assert (answer["schema"], answer["status"], answer["units"]) == ("clearway.fleet/1", "ok", "m")
    assert [r["name"] for r in answer["robots"]] == ["ada", "bob", "eve"]
    tracks = [np.array(r["track"]) for r in answer["robots"]]
    assert least_gap(tracks, [0.1, 0.1, 0.08]) >= -1e-7
    assert [r["arrival_s"] for r in answer["robots"]] == [t[-1, 0] for t in tracks]
    assert answer["makespan_s"] == max(t[-1, 0] for t in tracks)
    for wait in answer["dependencies"]:
        assert {wait["robot"], wait["waiting"]} < {"ada", "bob", "eve"}
    assert set(answer["timings_ms"]) > {"load", "roadmap", "fleet", "total"}


def test_json_robots_are_those_of_the_csv(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    rows = [line.split(", ") for line in ROBOTS.splitlines()]
    listed = [dict(zip(rows[0], row, strict=True)) for row in rows[1:]]
    csv = robots_file(tmp_path, ROBOTS)
    given = robots_file(tmp_path, json.dumps({"robots": listed}), "robots.json")
    answers = []
    for file in (csv, given):
        _, out, _ = asked(capsys, arena, "--robots", file, "--format", "json")
        answers.append(json.loads(out)["robots"])
    assert answers[0] == answers[1]


def test_text_says_when_each_arrives(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "answer.txt"
    robots = robots_file(tmp_path, ROBOTS)
    code, out, _ = asked(capsys, arena, "--robots", robots, "-o", target)
    assert (code, out) == (0, "")
    assert target.read_text().startswith("3 robots, the last arrives after ")
    assert re.search(r"^ada: \d+ points, arrives after", target.read_text(), re.M)


def test_a_picture_of_pixels_shows_each_robot_in_its_colour(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    still = tmp_path / "fleet.png"
    robots = robots_file(tmp_path, ROBOTS)
    assert asked(capsys, arena, "--robots", robots, "--render", still)[0] == 0
    colours = {tuple(c) for c in np.unique(cv2.imread(str(still)).reshape(-1, 3), axis=0)}
    for number in range(3):
        red, green, blue = colour_of(number)
        assert (blue, green, red) in colours


def test_the_picture_moves_a_disc_for_each_robot(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "fleet.svg"
    robots = robots_file(tmp_path, ROBOTS.replace("ada", "<ada & co>"))
    assert asked(capsys, arena, "--robots", robots, "--render", target)[0] == 0
    root = ElementTree.fromstring(target.read_text())
    moves = list(root.iter("{http://www.w3.org/2000/svg}animateTransform"))
    assert len(moves) == 3
    for move in moves:
        times = [float(t) for t in move.get("keyTimes", "").split(";")]
        assert len(times) == len(move.get("values", "").split(";"))
        assert times == sorted(times)
        assert (times[0], times[-1]) == (0.0, 1.0)
    assert "<ada & co>" in "".join(root.itertext())
    assert target.stat().st_size < 300 * 1024


def test_no_plan_ends_with_3_and_the_robots_names(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    robots = robots_file(tmp_path, ROBOTS.replace("1.5, -0.5, 0.08", "1.5, 0.45, 0.08"))
    code, out, err = asked(capsys, arena, "--robots", robots, "--format", "json")
    assert code == 3
    answer = json.loads(out)
    assert list(answer) == FIELDS
    assert (answer["status"], answer["blocking"]) == ("unreachable", ["ada", "eve"])
    assert answer["reason"].startswith("robots ada and eve: their goals are 0.05 apart")
    assert err == f"clearway: no plan: {answer['reason']}\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no robots"),
        (ROBOTS.splitlines()[0], "no robots"),
        (ROBOTS.replace("goal_y, ", ""), "row 1: there is no column goal_y"),
        (ROBOTS.replace("-1.5, 0.5, 1.5", "-1.5, x, 1.5"), "row 4, column start_y: 'x'"),
        (ROBOTS.replace("-1.5, 0.5, 1.5", "-1.5, nan, 1.5"), "row 4, column start_y"),
        (ROBOTS.replace("-1.5, 0.5, 1.5", "-1.5, , 1.5"), "row 4, column start_y: is missing"),
        (ROBOTS.replace("0.08", "-0.08"), "row 4, column radius: -0.08: must be > 0"),
        (ROBOTS.replace(", 0.08", ""), "row 4: has 5 columns, must have 6"),
        (ROBOTS.replace("eve", "ada"), "row 4, column name: 'ada' is there twice"),
        ('[{"name": "a"}]', "row 1, column start_x: is missing"),
        ('[{"name": "a", "start_x": true}]', "row 1, column start_x: True"),
        ("[3]", "row 1: must be an object"),
        ('{"fleet": []}', "must be a list of robots"),
        ('[{"name": }]', "row 1, column 11"),
    ],
)
def test_a_wrong_file_ends_with_2_and_says_where(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, said: str
) -> None:
    robots = robots_file(tmp_path, text)
    code, out, err = asked(capsys, arena, "--robots", robots)
    assert (code, out) == (2, "")
    assert err.startswith(f"clearway: error: {robots}: ")
    assert said in err
    assert err.count("\n") == 1


def test_files_that_are_read_are_not_written_over(
    arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    robots = robots_file(tmp_path, ROBOTS)
    assert asked(capsys, arena, "--robots", robots, "-o", robots)[0] == 2
    assert robots.read_text() == ROBOTS
    assert asked(capsys, arena, "--robots", tmp_path / "none.csv")[0] == 2
    assert asked(capsys, arena, "--robots", robots, "--render", tmp_path / "f.gif")[0] == 2


SPLIT = """\
#@ clearway.scene/1
#@ units m
#@ bounds given -2 -1 2 1
L 4 (-0.1,-1)(-0.1,1)(0.1,1)(0.1,-1)
"""
LEFT, RIGHT = "ada, -1.5, -0.5, -1.2, 0.8, 0.1", "eve, 1.5, 0.5, 1.5, -0.5, 0.08"


@pytest.mark.parametrize(
    ("arena_text", "bob", "reason", "blocking"),
    [
        (
            ARENA,
            "bob, -1.5, 0, 0.9, 0.1, 0.1",
            "no robot reaches the goal (0.9, 0.1); ada: no path even alone: the goal (0.9, 0.1)"
            " lies inside obstacle 1",
            [],
        ),
        (
            SPLIT,
            "bob, -1.5, 0, 1.5, 0, 0.1",
            "no robot is left for the goal (1.5, -0.5): each that reaches it is needed for another",
            [],
        ),
        (
            SPLIT,
            "bob, 0, 0.5, 1.5, 0, 0.1",
            "robot bob: no path even alone: the start (0, 0.5) lies inside obstacle 0",
            ["bob"],
        ),
    ],
)
def test_a_goal_that_no_robot_reaches_is_named_and_blamed_on_none(
    arena_text: str,
    bob: str,
    reason: str,
    blocking: list[str],
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    arena = tmp_path / "arena.scene"
    arena.write_text(arena_text)
    robots = robots_file(tmp_path, "\n".join((ROBOTS.splitlines()[0], LEFT, bob, RIGHT, "")))
    code, out, err = asked(capsys, arena, "--robots", robots, "--assign", "sum", "--format", "json")
    answer = json.loads(out or "{}")
    assert (code, answer.get("reason"), answer.get("blocking")) == (3, reason, blocking), err
    assert answer["proved"] is True
    assert reason in err


@pytest.mark.parametrize("objective", ["sum", "last"])
def test_goals_go_to_the_robots_that_suit(
    objective: str, arena: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    robots = robots_file(tmp_path, ROBOTS)
    code, out, _ = asked(
        capsys, arena, "--robots", robots, "--assign", objective, "--format", "json"
    )
    assert code == 0
    answer = json.loads(out)
    ends = [tuple(robot["track"][-1][1:]) for robot in answer["robots"]]
    assert sorted(ends) == sorted([(1.5, 0.5), (-1.5, -0.5), (1.5, -0.5)])
    # ada and bob need not change sides
    assert ends[1] in ((1.5, 0.5), (1.5, -0.5))
    assert answer["makespan_s"] < 30.0
