"""`clearway check` on a configuration of several robots."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from navigation.cli.setup.check import command, load_checked
from navigation.config import ConfigError

CONFIGS = Path(__file__).parents[4] / "configs"


def test_every_robot_has_its_line() -> None:
    result = CliRunner().invoke(command, [str(CONFIGS / "fleet.yaml")])
    assert result.exit_code == 0
    for line in (
        "ada        marker 1, radius 0.07 m, up to 0.25 m/s, simulated, 1 station",
        "finn       marker 6, radius 0.08 m, up to 0.25 m/s, simulated, 1 station",
        "tasks      no tasks",
    ):
        assert line in result.output


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (("left, stations: [{x_m: 2.20, y_m: 0.90}]", "left, stations: [{x_m: 1.0, y_m: 0.5}]"),
         "mission.robots[0].stations[0]"),
        (("right, x_m: 2.20, y_m: 0.90", "right, x_m: 1.00, y_m: 0.50"), "simulation.starts[1]"),
    ],
)  # fmt: skip
def test_a_place_inside_an_obstacle_is_said(
    change: tuple[str, str], key: str, tmp_path: Path
) -> None:
    text = (CONFIGS / "alcove.yaml").read_text()
    assert change[0] in text
    (tmp_path / "calibration.yaml").write_text(
        (CONFIGS / "simulation_calibration.yaml").read_text()
    )
    file = tmp_path / "alcove.yaml"
    file.write_text(
        text.replace(*change).replace("simulation_calibration.yaml", "calibration.yaml")
    )
    with pytest.raises(ConfigError) as caught:
        load_checked(file)
    (problem,) = caught.value.problems
    assert problem.key == key
    assert "clearance" in problem.message
