"""Bad input of every kind, through the entry point: the exit code, and one clear sentence.

Errors go to stderr as one sentence with what, where and the limit; no traceback without
``--debug``; nothing on stdout that looks like success.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import subprocess
import sys
import termios
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.support.pictures import Told, blank, box_and_disc, call, save

JOURNEY = ("--start", "40,40", "--goal", "600,440", "--radius", "9")
CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture that is well, and files that are not."""
    folder = tmp_path_factory.mktemp("bad")
    well = save(folder, "well.png", box_and_disc()).read_bytes()
    save(folder, "black.png", blank(200, 200, 0))
    save(folder, "one_black.png", blank(1, 1, 0))
    (folder / "empty.png").write_bytes(b"")
    (folder / "head_only.png").write_bytes(well[:60])
    (folder / "half.png").write_bytes(well[: len(well) // 2])
    (folder / "words.png").write_text("this is no picture\n")
    (folder / "noise.png").write_bytes(np.random.default_rng(1).bytes(2000))
    (folder / "folder.png").mkdir()
    (folder / "words.txt").write_text("this is no scene\n")
    (folder / "short.map").write_text("type octile\nheight 4\nwidth 4\nmap\n....\n")
    (folder / "no_image.yaml").write_text(
        "image: gone.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    return folder


def assert_refused(told: Told, code: int, *words: str) -> None:
    """One sentence on stderr that says each of ``words``, and nothing on stdout."""
    assert told.code == code, told
    lines = told.err.splitlines()
    assert len(lines) == 1, told.err
    assert lines[0].startswith("clearway: error: ")
    assert "Traceback" not in told.err
    assert "unexpected" not in told.err, "an error that nobody foresaw"
    for word in words:
        assert word in lines[0]
    assert told.out == ""


# Files.


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing.png", ["No such file"]),
        ("folder.png", ["directory"]),
        ("empty.png", ["empty"]),
        ("head_only.png", ["picture"]),
        ("half.png", ["picture"]),
        ("words.png", ["not a picture"]),
        ("noise.png", ["not a picture"]),
        ("black.png", ["no free space", "200 x 200"]),
        ("one_black.png", ["no free space"]),
    ],
)
def test_a_file_that_holds_no_usable_picture_is_refused_by_name(
    folder: Path, name: str, words: list[str]
) -> None:
    file = folder / name
    assert_refused(call("extract", file), 2, str(file), *words)
    assert_refused(call("plan", file, *JOURNEY), 2, str(file), *words)
    made = folder / "never.json"
    assert_refused(call("roadmap", file, "--radius", "9", "-o", made), 2, str(file), *words)
    assert not made.exists()


@pytest.mark.parametrize(
    ("name", "word"),
    [("words.txt", "words.txt:1"), ("short.map", "short.map"), ("no_image.yaml", "gone.pgm")],
)
def test_a_scene_or_map_that_cannot_be_read_is_refused_by_name(
    folder: Path, name: str, word: str
) -> None:
    assert_refused(call("plan", folder / name, *JOURNEY), 2, word)


def test_a_file_without_permission_is_refused(folder: Path) -> None:
    if os.geteuid() == 0:
        file = Path("/proc/self/mem")  # root may read any file but this one's first byte
        assert_refused(call("extract", file), 2, str(file))
        return
    file = folder / "secret.png"
    file.write_bytes(b"x")
    file.chmod(0)
    assert_refused(call("extract", file), 2, str(file), "ermission")


def test_an_all_white_picture_is_an_empty_arena(folder: Path) -> None:
    file = save(folder, "white.png", blank(640, 480, 255))
    assert call("extract", file).code == 0
    told = call("plan", file, *JOURNEY)
    assert told.code == 0
    assert without_warning(told, file).err == ""


def without_warning(told: Told, file: Path) -> Told:
    """The first line on stderr warns that the picture shows nothing; what else was said."""
    warning, rest = told.err.split("\n", 1)
    assert warning.startswith(f"clearway: warning: {file}: no obstacle was found in the picture")
    return told._replace(err=rest)


def test_a_picture_of_one_white_pixel_has_no_room(folder: Path) -> None:
    file = save(folder, "one.png", blank(1, 1, 255))
    assert call("extract", file).code == 0
    told = call("plan", file, "--start", "0,0", "--goal", "0,0", "--radius", "9")
    assert_no_path(without_warning(told, file), "start")


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
        (["roadmap", "a.png", "--radius", "1", "-o", "a.txt"], [".graphml, .geojson or .json"]),
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


def assert_no_path(told: Told, *words: str) -> None:
    """Exit code 3, the reason in the answer and as one sentence on stderr."""
    assert told.code == 3, told
    lines = told.err.splitlines()
    assert len(lines) == 1, told.err
    assert lines[0].startswith("clearway: no path for a robot of radius ")
    for word in words:
        assert word in lines[0]
        assert word in told.out
    assert "path of length" not in told.out


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


# Configurations.


@pytest.fixture
def text() -> str:
    """The simulated run's configuration; its neighbours are copied beside each test's file."""
    return (CONFIGS / "simulation.yaml").read_text()


@pytest.fixture
def tmp_path(tmp_path: Path) -> Path:
    """A folder with everything that the shipped configurations name."""
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    return tmp_path


def replaced(text: str, *changes: tuple[str, str]) -> str:
    """The text with the first of each pair, which has to be there, replaced by the second."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def place_of(text: str, part: str) -> str:
    """``line:column`` of ``part``, as an editor counts."""
    before = text[: text.index(part)]
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


def both(config: Path) -> Iterator[Told]:
    """What `check` and `run` say of a configuration: `run` drives no robot on a bad one."""
    yield call("check", config)
    yield call("run", config, "--once")


def test_every_wrong_key_and_value_is_told_at_once_with_line_and_column(
    tmp_path: Path, text: str
) -> None:
    text = replaced(
        text,
        ("radius_m: 0.09", "radius_m: -3"),
        ("rate_hz: 30", "rate_hz: fast"),
        ("baud: 115200", "bauds: 115200"),
        ("marker_id: 7", "marker_id: 7.5"),
        ("polarity: dark", "polarity: [1]"),
        ("lease_s: 0.5", "lease_s: .nan"),
    )
    file = tmp_path / "wrong.yaml"
    file.write_text(text)
    wanted = {
        "robot.radius_m": ("-3  ", "> 0"),
        "camera.rate_hz": ("fast", "number"),
        "serial.bauds": ("bauds", "baud"),
        "robot.marker_id": ("7.5", "whole"),
        "vision.polarity": ("[1]", "dark"),
        "safety.lease_s": (".nan", "finite"),
    }
    for told in both(file):
        assert (told.code, told.out) == (78, "")
        assert "6 errors" in told.err
        for key, (value, words) in wanted.items():
            line = next(line for line in told.err.splitlines() if f" {key}: " in line)
            assert line.startswith(f"{file}:{place_of(text, value)}: "), line
            assert words in line
        assert "Traceback" not in told.err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("bounds_m: [0.0, 0.0, 2.4, 1.8]", "bounds_m: [0.0, 0.0, 2.4"), ["not YAML"]),
        (("  polarity: dark", "\tpolarity: dark"), ["not YAML"]),
        (("radius_m: 0.09", "radius_m: .nan"), ["robot.radius_m", "finite"]),
        (("radius_m: 0.09", "radius_m: 0"), ["robot.radius_m", "> 0"]),
        (("radius_m: 0.09", "radius_m: 9"), ["robot.radius_m"]),
        (("x_m: 0.72", "x_m: 7.2"), ["mission.stations[0].x_m", "7.2"]),
        (("arena:\n", "arenas:\n"), ["did you mean 'arena'"]),
        (("serial:\n", "robot:\n"), ["second time"]),
        (("port: simulated", "port: [1, 2]"), ["serial.port"]),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_place(
    tmp_path: Path, text: str, change: tuple[str, str], words: list[str]
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, change))
    for told in both(file):
        assert (told.code, told.out) == (78, "")
        assert re.search(rf"^(clearway: error: )?{re.escape(str(file))}:\d+:\d+: ", told.err, re.M)
        for word in words:
            assert word in told.err


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (("laboratory.txt", "gone.txt"), "simulation.arena", "No such file"),
        (
            ("x_m: 1.42, y_m: 0.95", "x_m: 0.42, y_m: 1.16"),
            "mission.stations[1]",
            "clearance",
        ),
        (("x_m: 0.20, y_m: 0.20", "x_m: 0.42, y_m: 1.16"), "simulation.start", "clearance"),
    ],
)
def test_check_finds_what_only_the_named_files_can_show(
    tmp_path: Path, text: str, change: tuple[str, str], key: str, words: str
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, change))
    told = call("check", file)
    assert (told.code, told.out) == (78, "")
    assert key in told.err
    assert words in told.err


def test_a_run_without_its_arena_is_refused_before_anything_begins(
    tmp_path: Path, text: str
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, ("laboratory.txt", "gone.txt"), ("_dir: runs", "_dir: here")))
    told = call("run", file, "--once")
    assert told.code == 78
    assert "gone.txt" in told.err
    assert told.out == ""


@pytest.mark.parametrize("content", ["", "\n# a remark\n", "- 1\n", "7\n", "a: b: c\n", "\0", "é"])
def test_a_file_that_is_no_configuration_is_refused(tmp_path: Path, content: str) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(content)
    for told in both(file):
        assert (told.code, told.out) == (78, "")
        assert str(file) in told.err


def test_a_configuration_that_is_not_there_is_refused(tmp_path: Path) -> None:
    for told in both(tmp_path / "gone.yaml"):
        assert_refused(told, 78, "gone.yaml", "No such file")
    for told in both(tmp_path):
        assert_refused(told, 78, str(tmp_path), "directory")


# Serial ports and cameras.


def run_with(tmp_path: Path, text: str, *changes: tuple[str, str]) -> Told:
    file = tmp_path / "run.yaml"
    file.write_text(replaced(text, ("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}"), *changes))
    return call("run", file, "--once", "--quiet")


def test_a_run_on_a_missing_port_or_on_no_port_is_refused(tmp_path: Path, text: str) -> None:
    for port, words in ((tmp_path / "ttyUSB0", "no such device"), (tmp_path, "no serial port")):
        told = run_with(tmp_path, text, ("port: simulated", f"port: {port}"))
        assert_refused(told, 2, str(port), words)


def test_a_run_on_a_busy_port_is_refused(tmp_path: Path, text: str) -> None:
    host, robot = os.openpty()
    port = os.ttyname(robot)
    fcntl.ioctl(robot, termios.TIOCEXCL)
    fcntl.flock(robot, fcntl.LOCK_EX | fcntl.LOCK_NB)
    try:
        told = run_with(tmp_path, text, ("port: simulated", f"port: {port}"))
        assert_refused(told, 2, port, "in use")
        assert_refused(call("robot", "--port", port), 2, port, "in use")
    finally:
        os.close(robot)
        os.close(host)


def test_a_report_that_cannot_be_written_is_refused_before_the_run(
    tmp_path: Path, text: str
) -> None:
    file = tmp_path / "run.yaml"
    file.write_text(text)
    told = call("run", file, "--once", "--report", tmp_path / "gone" / "report.json")
    assert_refused(told, 2, "gone")


# The real process.


def clearway(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the installed program."""
    program = Path(sys.executable).with_name("clearway")
    return subprocess.run(
        [str(program), *map(str, arguments)], capture_output=True, text=True, timeout=120
    )


def test_the_program_itself_says_one_sentence_without_the_libraries_chatter(folder: Path) -> None:
    for name in ("half.png", "head_only.png"):
        done = clearway("extract", folder / name)
        assert_refused(Told(done.returncode, done.stdout, done.stderr), 2, name)


def test_debug_shows_the_traceback_wherever_it_stands(folder: Path) -> None:
    for arguments in (["--debug", "extract", "gone.png"], ["extract", "gone.png", "--debug"]):
        done = clearway(*arguments)
        assert done.returncode == 2
        assert "Traceback (most recent call last)" in done.stderr
        assert done.stderr.splitlines()[-1].startswith("clearway: error: gone.png: ")
        assert done.stdout == ""


def test_a_missing_port_ends_the_program_cleanly(tmp_path: Path, text: str) -> None:
    file = tmp_path / "run.yaml"
    runs = ("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}")
    file.write_text(replaced(text, runs, ("port: simulated", "port: no-such-port")))
    done = clearway("run", file, "--once", "--quiet")
    assert_refused(Told(done.returncode, done.stdout, done.stderr), 2, "no-such-port")
