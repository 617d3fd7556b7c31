"""Numbers and words of `plan` and `roadmap` that cannot be, and places where no robot can be."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.pictures import call
from tests.system.bad_input.refusals import JOURNEY, assert_no_path, assert_refused

# Numbers and words of `plan` and `roadmap`.

NOT_A_PLACE = ["", "1", "a,b", "1,2,3,4", "nan,1", "1,inf", "1;2", "40,40,nan", "1_0,5"]


@pytest.mark.parametrize("place", NOT_A_PLACE)
def test_a_place_that_is_no_place_is_refused(folder: Path, place: str) -> None:
    for option in ("--start", "--goal", "--via"):
        values = {"--start": "40,40", "--goal": "600,440"} | {option: place}
        arguments = [word for pair in values.items() for word in pair]
        told = call("plan", folder / "well.png", *arguments, "--radius", "9")
        assert_refused(told, 2, option, repr(place), "X,Y")


@pytest.mark.parametrize("radius", ["0", "-0.0", "-1", "nan", "inf", "-inf", "abc", ""])
def test_a_radius_that_is_not_finite_and_positive_is_refused(folder: Path, radius: str) -> None:
    file = folder / "well.png"
    told = call("plan", file, "--start", "40,40", "--goal", "600,440", "--radius", radius)
    assert_refused(told, 2, "--radius", "> 0")
    made = folder / "r.json"
    assert_refused(call("roadmap", file, "--radius", radius, "-o", made), 2, "--radius", "> 0")
    assert not made.exists()


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--spacing", "18", ["--spacing", "2 radius", "18"]),
        ("--spacing", "1e300", ["2 radius"]),
        ("--spacing", "0", ["> 0"]),
        ("--spacing", "nan", ["> 0"]),
        ("--margin", "-1", [">= 0"]),
        ("--margin", "nan", [">= 0"]),
        ("--margin", "inf", [">= 0"]),
        ("--prefer", "nonsense", ["'nonsense'", "clearance, length, balanced"]),
        ("--prefer", "1.5", ["0 (length)"]),
        ("--prefer", "nan", ["0 (length)"]),
        ("--order", "worst", ["fixed"]),
        ("--alternatives", "-1", ["0<=x"]),
        ("--alternatives", "many", ["--alternatives"]),
        ("--polarity", "pink", ["dark"]),
        ("--format", "xml", ["json"]),
        ("--render", "plan.bmp", [".svg or .png"]),
        ("--render", "plan", [".svg or .png"]),
    ],
)
def test_an_option_out_of_range_is_refused_with_its_limit(
    folder: Path, option: str, value: str, words: list[str]
) -> None:
    assert_refused(call("plan", folder / "well.png", *JOURNEY, option, value), 2, *words)


def test_an_answer_into_a_missing_folder_is_refused_and_nothing_looks_like_success(
    folder: Path,
) -> None:
    well, gone = folder / "well.png", folder / "gone"
    told = call("plan", well, *JOURNEY, "-o", gone / "a.json")
    assert_refused(told, 2, str(gone))
    assert_refused(call("plan", well, *JOURNEY, "--render", gone / "a.svg"), 2, str(gone))
    assert_refused(call("plan", well, *JOURNEY, "-o", folder), 2, str(folder), "directory")
    assert_refused(call("extract", well, "-o", gone / "a.txt"), 2, str(gone))
    assert_refused(call("extract", well, "--render", gone / "a.png"), 2, str(gone))
    told = call("roadmap", well, "--radius", "9", "-o", gone / "a.json")
    assert_refused(told, 2, str(gone))
    told = call(
        "roadmap", well, "--radius", "9", "-o", folder / "a.json", "--render", gone / "a.svg"
    )
    assert_refused(told, 2, str(gone))


def test_extract_draws_only_what_it_has_a_writer_for(folder: Path) -> None:
    told = call("extract", folder / "well.png", "--render", folder / "a.xyz")
    assert_refused(told, 2, "a.xyz", ".png")


def test_extract_refuses_a_level_outside_the_greys_and_one_that_nobody_uses(folder: Path) -> None:
    well = folder / "well.png"
    for level in ("300", "-1", "nan", "abc"):
        assert_refused(call("extract", well, "--method", "fixed", "--threshold", level), 2, level)
    assert_refused(call("extract", well, "--method", "otsu", "--threshold", "90"), 2, "fixed")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["plaan"], ["'plaan'", "'plan'"]),
        (["zzz"], ["'zzz'", "extract"]),
        (["extract"], ["IMAGE"]),
        (["plan"], ["SOURCE"]),
        (["plan", "a.png", "--goal", "1,1", "--radius", "1"], ["--start"]),
        (["plan", "a.png", "--start", "1,1", "--radius", "1"], ["--goal"]),
        (["plan", "a.png", "--start", "1,1", "--goal", "1,1"], ["--radius"]),
        (["plan", "a.png", "--bogus"], ["--bogus"]),
        (["roadmap", "a.png", "--radius", "1"], ["--output"]),
        (
            ["roadmap", "a.png", "--radius", "1", "-o", "a.txt"],
            [".graphml, .geojson, .json, .lif, .yaml or .yml"],
        ),
        (["run"], ["CONFIG"]),
        (["check"], ["CONFIG"]),
        (["--nonsense"], ["--nonsense"]),
        (["robot", "--port", "no-such-port"], ["no-such-port"]),
        (["robot", "--faults", "nope=1"], ["'nope'", "drop"]),
        (["robot", "--faults", "drop=2"], ["drop"]),
        (["robot", "--start", "x"], ["'x'"]),
        (["robot", "--start", "nan,0"], ["nan"]),
        (["robot", "--baud", "1"], ["1200"]),
    ],
)
def test_wrong_usage_is_refused_with_what_was_expected(
    arguments: list[str], words: list[str]
) -> None:
    assert_refused(call(*arguments), 2, *words)


# Places where no robot can be: an expected answer, with exit code 3.


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("250,200", ["inside obstacle"]),
        ("200,200", ["inside obstacle"]),
        ("-5,40", ["outside"]),
        ("1000,40", ["outside"]),
        ("0,0", ["0.5", "9"]),
        ("-0.5,-0.5", ["9"]),
        ("639.5,40", ["9"]),
        ("1e300,40", ["outside"]),
    ],
)
def test_a_start_or_goal_where_no_robot_fits_has_no_path_and_says_why(
    folder: Path, place: str, words: list[str]
) -> None:
    well = folder / "well.png"
    told = call("plan", well, "--start", place, "--goal", "600,440", "--radius", "9")
    assert_no_path(told, "start", *words)
    told = call("plan", well, "--start", "40,40", "--goal", place, "--radius", "9")
    assert_no_path(told, "goal", *words)


def test_a_robot_larger_than_the_arena_has_no_path(folder: Path) -> None:
    for radius in ("500", "1e9", "1e300"):
        told = call(
            "plan", folder / "well.png", "--start", "40,40", "--goal", "600,440", "--radius", radius
        )
        assert_no_path(told, "start")


def test_the_sentence_is_told_though_the_answer_goes_into_a_file(folder: Path) -> None:
    answer = folder / "answer.json"
    told = call(
        *("plan", folder / "well.png", "--start", "250,200", "--goal", "600,440"),
        *("--radius", "9", "--format", "json", "-o", answer),
    )
    assert told.code == 3
    assert told.out == ""
    assert "inside obstacle" in told.err
    assert '"unreachable"' in answer.read_text()


def test_a_journey_to_where_the_robot_stands_is_a_path_of_length_zero(folder: Path) -> None:
    told = call("plan", folder / "well.png", "--start", "40,40", "--goal", "40,40", "--radius", "9")
    assert (told.code, told.err) == (0, "")
    assert "path of length 0 px" in told.out
