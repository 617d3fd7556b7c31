"""check, init and schema: from a first file to a configuration that can be trusted."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from navigation.cli.main import run
from navigation.config import load_config
from navigation.config.reference import json_schema, reference_markdown
from navigation.config.sections import Config
from vision.calibration.calibration import Calibration
from vision.calibration.calibration_file import save_calibration

ROOT = Path(__file__).parents[4]


ZONES = ROOT / "configs" / "zones.yaml"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "{x_m: 0.7, y_m: 1.5}",
            "{x_m: 1.2, y_m: 1.5}",
            "mission.robots[0].stations[1]: the station (1.2, 1.5) is in keep-out zone 'desk'",
        ),
        (
            "{x_m: 0.25, y_m: 1.3}",
            "{x_m: 2.15, y_m: 1.12}",
            "mission.robots[1].stations[0]: the station (2.15, 1.12) is 0.02 m from no-waiting "
            "zone 'door', nearer than the radius of 0.07 m",
        ),
    ],
)
def test_a_station_that_a_zone_forbids_is_named(
    old: str, new: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = ZONES.read_text()
    assert old in text
    calibration = "simulation_calibration.yaml"
    (tmp_path / calibration).write_bytes((ZONES.parent / calibration).read_bytes())
    (tmp_path / "zones.yaml").write_text(text.replace(old, new))
    assert run(["check", str(tmp_path / "zones.yaml")]) == 78
    assert f"{said}: must be where the zones let a robot stop" in capsys.readouterr().err


def _init(tmp_path: Path, *options: str) -> Path:
    file = tmp_path / "clearway.yaml"
    assert run(["init", str(file), *options]) == 0
    return file


def _changed(file: Path, old: str, new: str) -> Path:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    return file


def test_a_first_configuration_is_sound_and_runs_without_other_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = _init(tmp_path)
    assert run(["check", str(file)]) == 0
    out = capsys.readouterr().out
    assert f"{file}: ok\n" in out
    assert "marker 7, radius 0.09 m" in out
    assert "2 stations" in out


def test_a_first_configuration_for_real_hardware_lacks_its_calibration_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = _init(tmp_path, "--real")
    assert load_config(file, {}).simulation is None
    assert run(["check", str(file)]) == 78
    err = capsys.readouterr().err
    assert "camera.calibration" in err
    assert err.count("clearway.yaml:") == 1


def test_a_first_configuration_names_every_key(tmp_path: Path) -> None:
    text = _init(tmp_path).read_text()
    schema = json_schema()
    properties = [schema["properties"], *(part["properties"] for part in schema["$defs"].values())]
    assert [key for keys in properties for key in keys if f"{key}:" not in text] == []


@pytest.mark.parametrize("real", [False, True])
def test_a_first_configuration_is_at_most_as_wide_as_the_code(tmp_path: Path, real: bool) -> None:
    lines = _init(tmp_path, *(["--real"] if real else [])).read_text().splitlines()
    assert max(map(len, lines)) <= 100 + len(str(tmp_path))


@pytest.mark.parametrize("real", [False, True])
def test_comments_of_keys_that_are_commented_out_are_indented_as_their_keys(
    tmp_path: Path, real: bool
) -> None:
    """Taking '# ' away from a block gives its keys, with their comments right above them."""
    lines = _init(tmp_path, *(["--real"] if real else [])).read_text().splitlines()
    seen = 0
    for above, key in pairwise(lines):
        if not re.match(r"# +(- )?\w+:( |$)", key) or not re.match(r"# +[^-]", above):
            continue
        if re.match(r"# +(- )?\w+:( |$)", above) or "clearway" in above:
            continue
        seen += 1
        depth = len(key) - len(key[2:].lstrip(" "))
        assert above.startswith(f"{key[:depth]}# "), (above, key)
    assert seen >= 1


def test_init_names_the_folder_that_is_not_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", str(tmp_path / "gone" / "arena.yaml")]) == 2
    assert f"there is no directory {tmp_path / 'gone'}" in capsys.readouterr().err


def test_init_overwrites_only_when_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = _init(tmp_path)
    file.write_text("mine")
    assert run(["init", str(file)]) == 2
    assert "exists; --force overwrites it" in capsys.readouterr().err
    assert file.read_text() == "mine"
    assert run(["init", str(file), "--force"]) == 0
    assert file.read_text() != "mine"


def test_init_into_a_folder_that_is_missing_is_a_usage_error(tmp_path: Path) -> None:
    assert run(["init", str(tmp_path / "no" / "x.yaml")]) == 2


def test_check_tells_every_error_with_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "run.yaml"
    file.write_text("arena:\n  bounds: 3\ncamera: {source: 0}\nrobot: {}\n")
    assert run(["check", str(file)]) == 78
    err = capsys.readouterr().err
    for told in (
        f"{file}:2:3: arena.bounds: unknown key; did you mean 'bounds_m'?",
        f"{file}:3:9: camera: needs a calibration",
        f"{file}:4:1: robot.marker_id: is missing",
        f"{file}:4:1: robot.radius_m: is missing",
    ):
        assert told in err


def test_check_of_a_missing_file_is_a_bad_configuration(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["check", str(tmp_path / "no.yaml")]) == 78
    assert "No such file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("source: simulated", "source: simulated\n  calibration: no.yaml", "camera.calibration: "),
        ("C (0.50,1.22) 0.14", "C (0.50,1.22)", "simulation.arena_text: "),
        ("#@ units m", "#@ units px", "simulation.arena_text: "),
        ("C (0.50,1.22) 0.14", "C (0.2,0.2) 0.14", "simulation.start"),
        ("x_m: 1.4, y_m: 0.9", "x_m: 0.5, y_m: 1.2", "mission.stations[0]: has a clearance of -"),
        ('faults: ""', "faults: bite=1", "simulation.robot.faults: "),
        ("  arena_text: |", "  arena: nowhere.txt\n  x: |", "x: unknown key"),
    ],
)
def test_check_looks_into_the_files_and_the_arena(
    old: str, new: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = _changed(_init(tmp_path), old, new)
    assert run(["check", str(file)]) == 78
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[0.0, 0.0, 2.4, 1.8]", "[0.0, 0.0, 2.4, 2.8]", "the corner (0, 2.8) lies at pixel"),
        ("focal_px: 1235.0", "focal_px: 2000", "outside the camera's 1280x960"),
        ("[-0.08, 0.02, 0.0004,", "[-2.0, 0.02, 0.0004,", "simulation.camera: distortion"),
        ("size_px: [1280, 960]", "size_px: [640, 480]", "outside the camera's 640x480"),
    ],
)
def test_check_finds_an_arena_that_the_camera_does_not_see(
    old: str, new: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["check", str(_changed(_init(tmp_path), old, new))]) == 78
    assert told in capsys.readouterr().err


def test_check_finds_an_arena_and_a_marker_in_other_units_than_metres(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A picture of 1280 pixels cannot show a marker of 9 cm in an arena of 200 m."""
    scale = ("calibration: calibration.yaml", "metres_per_pixel: 0.2")
    file = _changed(_init(tmp_path, "--real"), *scale)
    _changed(file, "bounds_m: [0.0, 0.0, 2.4, 1.8]", "bounds_m: [0.0, 0.0, 200.0, 150.0]")
    _changed(file, "marker_height_m: 0.12", "marker_height_m: 0.0")
    assert run(["check", str(file)]) == 78
    error = capsys.readouterr().err
    assert "robot.marker_size_m: 0.09 m are 0." in error
    assert "px in the picture: must be >= 6 px, one for each cell" in error


def test_check_says_how_a_scale_alone_can_be_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scale = ("calibration: calibration.yaml", "metres_per_pixel: 0.0019")
    assert run(["check", str(_changed(_init(tmp_path, "--real"), *scale))]) == 78
    assert "robot.marker_height_m: must be 0 with metres_per_pixel" in capsys.readouterr().err


def test_check_finds_a_calibration_for_other_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_calibration(Calibration.from_scale(0.005, (640, 480)), tmp_path / "c.yaml")
    file = _changed(_init(tmp_path), "# calibration:", "calibration: c.yaml #")
    assert run(["check", str(file)]) == 78
    assert "is for pictures of 640x480, camera.size_px asks for 1280x960" in capsys.readouterr().err


def test_check_says_which_arena_file_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "configs/simulation.yaml").read_text()
    file = tmp_path / "run.yaml"
    file.write_text(text)
    assert run(["check", str(file)]) == 78
    err = capsys.readouterr().err
    assert "simulation.arena: " in err
    assert "laboratory.txt" in err


def test_check_heeds_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = _init(tmp_path)
    monkeypatch.setenv("CLEARWAY_ROBOT__RADIUS_M", "-1")
    assert run(["check", str(file)]) == 78
    assert "environment CLEARWAY_ROBOT__RADIUS_M: robot.radius_m" in capsys.readouterr().err


def test_what_is_wrong_in_files_is_told_with_the_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "configs/simulation.yaml").read_text()
    text = text.replace(
        "simulation_calibration.yaml", str(ROOT / "configs/simulation_calibration.yaml")
    )
    text = text.replace("polarity: dark", "polartiy: dark")
    text = text.replace("arenas/laboratory.txt", "arenas/nope.txt")
    (tmp_path / "run.yaml").write_text(text)
    assert run(["check", str(tmp_path / "run.yaml")]) == 78
    told = capsys.readouterr().err
    assert "2 errors" in told
    assert "did you mean 'polarity'" in told
    assert "nope.txt: No such file" in told


def test_an_obstacle_of_the_simulation_is_read_when_it_is_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = _init(tmp_path)
    records = "obstacles: [{record: 'X 1'}, {record: 'C (1,1) -1'}]"
    _changed(file, "\nsimulation:", f"\nsimulation:\n  {records}")
    assert run(["check", str(file)]) == 78
    told = capsys.readouterr().err
    assert "simulation.obstacles[0].record: 'X' is not a record" in told
    assert "simulation.obstacles[1].record: " in told
    assert "~~" in told
    assert run(["run", str(file), "--once"]) == 78


def test_a_marker_above_the_camera_is_refused_beforehand(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "configs/simulation.yaml").read_text()
    text = text.replace("marker_height_m: 0.12", "marker_height_m: 5")
    (tmp_path / "arenas").mkdir()
    for name in ("simulation_calibration.yaml", "arenas/laboratory.txt"):
        (tmp_path / name).write_text((ROOT / "configs" / name).read_text())
    (tmp_path / "run.yaml").write_text(text)
    assert run(["check", str(tmp_path / "run.yaml")]) == 78
    told = capsys.readouterr().err
    assert "robot.marker_height_m: must be below the camera at 2." in told


# The schema and the reference.


def test_the_schema_is_json_schema_and_closed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["$schema"].startswith("https://json-schema.org/")
    assert set(schema["required"]) == {"arena", "robot"}
    assert [one["required"] for one in schema["anyOf"]] == [["camera"], ["cameras"]]
    assert schema["additionalProperties"] is False
    assert all(part["additionalProperties"] is False for part in schema["$defs"].values())


def test_every_key_is_described_in_the_schema() -> None:
    schema: dict[str, Any] = json_schema()
    silent = [
        f"{name}.{key}"
        for name, part in schema["$defs"].items()
        for key, value in part["properties"].items()
        if not value.get("description")
    ]
    assert silent == []


def test_the_reference_in_docs_is_the_one_that_the_command_writes() -> None:
    """Where this fails: `clearway schema --format markdown -o docs/configuration.md`."""
    assert (ROOT / "docs/configuration.md").read_text() == reference_markdown()


def test_the_reference_has_a_heading_for_every_section() -> None:
    text = reference_markdown()
    for name in Config.model_fields:
        assert f"\n## {name}\n" in text
    assert "### simulation.camera\n" in text


def test_the_schema_goes_into_a_file(tmp_path: Path) -> None:
    file = tmp_path / "schema.json"
    assert run(["schema", "-o", str(file)]) == 0
    assert json.loads(file.read_text()) == json_schema()


def test_check_tells_of_files_that_are_missing_whatever_else_is_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "run.yaml"
    simulation = "simulation: {arena: nowhere.txt, start: {x_m: 0.2, y_m: 0.2}, sede: 3}"
    camera = "camera: {source: simulated, calibration: no.yaml}"
    file.write_text(f"arena:\n  bounds: 3\n{camera}\nrobot: {{}}\n{simulation}\n")
    assert run(["check", str(file)]) == 78
    err = capsys.readouterr().err
    for told in (
        f"{file}:3:42: camera.calibration: {tmp_path / 'no.yaml'}: No such file or directory",
        f"{file}:5:21: simulation.arena: {tmp_path / 'nowhere.txt'}: No such file or directory",
        f"{file}:4:1: robot.marker_id: is missing",
    ):
        assert told in err
