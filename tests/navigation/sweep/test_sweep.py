"""Sweeps: the same rows for the same seed, whatever becomes of the workers."""

from __future__ import annotations

import csv
import json
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navigation.config import Config, load_config
from navigation.simulator.arena import load_arena
from navigation.sweep.runs import MOST_ATTEMPTS, Row, Sweep, Work, run_rows
from navigation.sweep.table import SweepFile, summarise_rows, write_rows
from navigation.sweep.variations import (
    MOST_SPREAD,
    WHEEL_ERROR,
    RobotVariation,
    SweepError,
    Variation,
    variation,
    varied,
)
from navigation.sweep.workers import local_executor
from tests.support.pictures import call
from tests.support.runs import sweeps

pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[3] / "configs"

SMALL = f"""
arena:
  bounds_m: [0.0, 0.0, 2.4, 1.8]
camera:
  source: simulated
  size_px: [640, 480]
  rate_hz: 15
robot:
  marker_id: 7
  marker_size_m: 0.12
  marker_height_m: 0.12
  radius_m: 0.1
mission:
  tolerance_m: 0.03
  tolerance_deg: 5
  stations:
    - {{x_m: 0.20, y_m: 0.75}}
simulation:
  arena: {CONFIGS}/arenas/laboratory.txt
  start: {{x_m: 0.20, y_m: 0.20, heading_deg: 90}}
  time_limit_s: 30
  camera: {{position_m: [1.155, 0.975, 2.5], focal_px: 617, centre_offset_px: [2.6, -1.9]}}
"""
"""A run of a few seconds with small pictures."""


@pytest.fixture
def config(tmp_path: Path) -> Config:
    """The simulated run, with a folder of its own for marks."""
    loaded = load_config(CONFIGS / "simulation.yaml", {})
    changed = loaded.recording.model_copy(update={"runs_dir": tmp_path})
    return loaded.model_copy(update={"recording": changed})


def swept(
    config: Config,
    runs: int,
    work: Work,
    open_executor: Callable[[], Executor] = lambda: local_executor(2),
    workers: int = 2,
) -> tuple[list[Row], Sweep]:
    chosen = [variation(config, 5, run) for run in range(runs)]
    sweep = Sweep(config, chosen, open_executor, workers, work)
    return sorted(sweep.rows(), key=lambda row: row.run), sweep


# Variations.


def one_robot(config: Config, seed: int, run: int, spread: float = 1.0) -> RobotVariation:
    return variation(config, seed, run, spread).robots[""]


def test_a_variation_is_the_same_every_time_and_unlike_all_others(config: Config) -> None:
    first = [one_robot(config, 5, run) for run in range(20)]
    assert first == [one_robot(config, 5, run) for run in range(20)]
    assert len({v.seed for v in first}) == 20
    assert first[0] != one_robot(config, 6, 0)


def test_errors_are_spread_up_to_their_limits(config: Config) -> None:
    many = [one_robot(config, 1, run) for run in range(300)]
    assert max(abs(v.wheel_error_left) for v in many) == pytest.approx(WHEEL_ERROR, rel=0.03)
    assert all(abs(v.wheel_error_right) <= WHEEL_ERROR for v in many)
    assert all(v.slip >= 0.0 and v.noise_grey >= 0.0 and v.blur_px >= 0.0 for v in many)
    wide = one_robot(config, 1, 7, 2.0)
    assert wide.track_error == pytest.approx(2.0 * many[7].track_error)


def test_without_spread_only_the_seed_varies(config: Config) -> None:
    assert config.simulation is not None
    one = varied(config, variation(config, 5, 0, 0.0))[0].simulation
    assert one is not None
    assert one.seed != config.simulation.seed
    assert one.model_copy(update={"seed": config.simulation.seed}) == config.simulation


def test_every_start_is_free(config: Config) -> None:
    """One inside an obstacle or a wall would make a crash of a run that can be driven."""
    arena = load_arena(config)
    wanted_m = config.robot.radius_m + config.planning.margin_m
    for spread in (1.0, MOST_SPREAD):
        many = [one_robot(config, 2, run, spread) for run in range(60)]
        starts = np.array([(v.start_x_m, v.start_y_m) for v in many])
        assert arena.clearances(starts).min() >= wanted_m
        assert len({tuple(start) for start in starts}) == 60
    assert np.ptp(starts, axis=0).min() > 0.2


def test_a_tight_start_varies_only_as_far_as_it_gets_no_tighter(config: Config) -> None:
    assert config.simulation is not None
    start = config.simulation.start.model_copy(update={"x_m": 0.1, "y_m": 0.1})
    tight = config.simulation.model_copy(update={"start": start})
    changed = config.model_copy(update={"simulation": tight})
    many = [one_robot(changed, 2, run) for run in range(60)]
    assert all(v.start_x_m >= 0.1 and v.start_y_m >= 0.1 for v in many)
    assert any(v.start_x_m > 0.1 for v in many)


@pytest.mark.parametrize("spread", [-0.1, 16.1, float("inf"), float("nan")])
def test_a_spread_beyond_what_a_configuration_takes_is_refused(
    spread: float, config: Config
) -> None:
    with pytest.raises(SweepError, match=r"spread .*: must be >= 0 and <= 16"):
        variation(config, 2, 0, spread)


def test_the_widest_spread_makes_legal_configurations(config: Config) -> None:
    for run in range(60):
        widest = varied(config, variation(config, 2, run, MOST_SPREAD))[0].simulation
        assert widest is not None
        assert type(widest).model_validate(widest.model_dump()) == widest


def test_a_sweep_needs_a_simulation(config: Config) -> None:
    with pytest.raises(SweepError, match="needs a section 'simulation'"):
        variation(config.model_copy(update={"simulation": None}), 0, 0)


# Workers.


def test_every_variation_gets_its_row_once(config: Config) -> None:
    rows, sweep = swept(config, 12, sweeps.quick)
    assert [row.run for row in rows] == list(range(12))
    assert sweep.deaths == 0


def test_a_killed_worker_costs_time_and_no_row(config: Config, tmp_path: Path) -> None:
    rows, sweep = swept(config, 12, sweeps.once_killed)
    undisturbed, _ = swept(config, 12, sweeps.quick, lambda: ThreadPoolExecutor(2))
    assert (tmp_path / "killed").exists()
    assert rows == undisturbed
    assert sweep.deaths == 1


def test_a_run_that_kills_every_worker_is_told_and_the_others_are_done(
    config: Config, tmp_path: Path
) -> None:
    rows, sweep = swept(config, 12, sweeps.always_killed, lambda: local_executor(1), 1)
    assert [row.run for row in rows] == list(range(12))
    assert {row.run: row.state for row in rows if row.state != "done"} == {3: "killed"}
    assert len(list(tmp_path.glob("try-*"))) == sweep.deaths == MOST_ATTEMPTS


def test_a_bug_in_a_run_is_its_row_s_reason(config: Config) -> None:
    rows, _ = swept(config, 6, sweeps.broken)
    assert (rows[3].state, rows[3].reason) == ("crashed", "RuntimeError: a bug in run 3")
    assert [row.state for row in rows].count("done") == 5


def test_only_a_few_runs_are_handed_out_at_a_time(config: Config) -> None:
    lock, now, most = threading.Lock(), [0], [0]

    class Counted(ThreadPoolExecutor):
        def submit(self, *arguments: Any, **options: Any) -> Any:
            with lock:
                now[0] += 1
                most[0] = max(most[0], now[0])
            future = super().submit(*arguments, **options)
            future.add_done_callback(lambda _: now.__setitem__(0, now[0] - 1))
            return future

    swept(config, 40, sweeps.quick, lambda: Counted(2))
    assert most[0] <= 4


# Real runs.


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("small") / "small.yaml"
    file.write_text(SMALL)
    return file


def test_the_same_seeds_give_the_same_rows_in_one_process_or_in_two(
    small: Path, tmp_path: Path
) -> None:
    told = call(
        "sweep", small, "--runs", 2, "--seed", 4, "--workers", 2, "-o", tmp_path / "s.csv",
        "--format", "json",
    )  # fmt: skip
    assert told.code == 0, told
    summary = json.loads(told.out)
    assert summary["states"] == {"done": 2}
    assert summary["measures"]["min_clearance_m"]["least"] >= 0.1
    with (tmp_path / "s.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["run"] for row in rows] == ["0", "1"]
    config = load_config(small, {})
    for number in (0, 1):
        (here,) = run_rows(config, variation(config, 4, number))
        values = {name: getattr(here, name) for name in rows[number]}
        written = {name: "" if value is None else str(value) for name, value in values.items()}
        assert written == rows[number]


@pytest.mark.parametrize("noise_grey", [0.0, 0.00123])
def test_a_run_with_hardly_any_noise_is_driven(noise_grey: float, small: Path) -> None:
    """Its robot stands in the beginning: the pictures repeat, and the camera is not frozen."""
    config = load_config(small, {})
    quiet = Variation(0, {"": replace(one_robot(config, 4, 0), noise_grey=noise_grey)})
    for pictures in (True, False):
        (row,) = run_rows(config, quiet, pictures=pictures)
        assert row.state == "done", row.reason


def test_a_sweep_without_pictures_has_the_rows_of_runs_without_pictures(
    small: Path, tmp_path: Path
) -> None:
    told = call(
        "sweep", small, "--runs", 1, "--seed", 4, "--workers", 1, "--no-pictures",
        "-o", tmp_path / "s.csv", "--format", "json",
    )  # fmt: skip
    assert told.code == 0, told
    with (tmp_path / "s.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    config = load_config(small, {})
    without, drawn = (
        run_rows(config, variation(config, 4, 0), pictures=pictures)[0]
        for pictures in (False, True)
    )
    assert row["goal_error_m"] == str(without.goal_error_m) != str(drawn.goal_error_m)
    assert (without.state, without.stations_visited) == (drawn.state, drawn.stations_visited)


def test_a_sweep_without_pictures_refuses_what_only_pictures_show(
    small: Path, tmp_path: Path
) -> None:
    knocked = tmp_path / "knocked.yaml"
    text = small.read_text()
    assert text.count("focal_px: 617,") == 1
    knocks = "focal_px: 617, knocks: [{from_s: 2.0, tilt_deg: [1.0, 0.0]}],"
    knocked.write_text(text.replace("focal_px: 617,", knocks))
    told = call("sweep", knocked, "--runs", 1, "--no-pictures", "-o", tmp_path / "s.csv")
    assert told.code == 2
    assert "only a picture shows that a camera was knocked" in told.err
    assert not (tmp_path / "s.csv").exists()


# A cluster.


@pytest.fixture
def cluster() -> Iterator[Any]:
    distributed: Any = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as local:
        yield local


def test_a_cluster_gives_the_same_rows_though_one_of_its_workers_is_killed(
    config: Config, cluster: Any
) -> None:
    from navigation.sweep.workers import Cluster

    ours = Cluster(cluster.scheduler_address)
    assert ours.workers() == 2
    rows, _ = swept(config, 12, sweeps.once_killed, ours.executor)
    ours.close()
    undisturbed, _ = swept(config, 12, sweeps.quick, lambda: ThreadPoolExecutor(2))
    assert rows == undisturbed


def test_a_scheduler_that_is_not_there_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    from navigation.sweep import workers

    monkeypatch.setattr(workers, "CONNECT_S", 0.5)
    with pytest.raises(SweepError, match=r"scheduler tcp://127\.0\.0\.1:1"):
        workers.Cluster("tcp://127.0.0.1:1")


# The file.


def row(run: int, state: str = "done", duration_s: float | None = None) -> Row:
    return Row(run, 100 + run, state, "", duration_s=duration_s)


def test_a_sweep_that_is_cut_short_keeps_the_rows_it_had(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"

    def cut_short() -> None:
        with SweepFile(path) as file:
            file.add(row(1))
            file.add(row(0))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cut_short()
    with path.open(newline="") as written:
        assert [one["run"] for one in csv.DictReader(written)] == ["1", "0"]


def test_a_whole_sweep_is_in_the_order_of_its_runs(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    with SweepFile(path) as file:
        for run in (2, 0, 1):
            file.add(row(run))
    with path.open(newline="") as written:
        assert [one["run"] for one in csv.DictReader(written)] == ["0", "1", "2"]


def test_the_summary_counts_states_and_spreads_measures() -> None:
    rows = [row(run, duration_s=float(run)) for run in range(101)]
    summary = summarise_rows([*rows, row(101, "failed")])
    assert summary.states == {"done": 101, "failed": 1}
    spread = summary.measures["duration_s"]
    assert (spread.count, spread.least, spread.median, spread.p95, spread.most) == (
        101, 0.0, 50.0, 95.0, 100.0,
    )  # fmt: skip
    assert "goal_error_m" not in summary.measures


def test_a_table_is_csv_or_parquet_and_parquet_needs_pyarrow(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r"must end in .csv or .parquet"):
        SweepFile(tmp_path / "s.xlsx")
    try:
        import pyarrow.parquet
    except ImportError:
        with pytest.raises(SweepError, match="pip install pyarrow"):
            SweepFile(tmp_path / "s.parquet")
        return
    write_rows(tmp_path / "s.parquet", [row(0), row(1)])
    assert pyarrow.parquet.read_table(tmp_path / "s.parquet").column("run").to_pylist() == [0, 1]
