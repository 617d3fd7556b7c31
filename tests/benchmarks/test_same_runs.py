"""The instrument that compares runs: what it takes for the same, and what it notices."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from benchmarks.same_runs.__main__ import main
from benchmarks.same_runs.cases import Case, all_cases, sample
from benchmarks.same_runs.kept import KeptError, differences, play, read
from benchmarks.same_runs.trace import BLOCK, PARTS, Trace, first_difference
from benchmarks.same_runs.troubles import TROUBLES
from navigation.run.virtual_link import VirtualLink

ONE = Case("hardware_in_the_loop", "stop", 0)
SEVERAL = Case("alcove", "stop", 1)


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """The runs end two seconds after their trouble."""
    monkeypatch.setattr("benchmarks.same_runs.script.AFTERWARDS_S", 2.0)


@pytest.mark.slow
@pytest.mark.parametrize("case", [ONE, SEVERAL], ids=["one robot", "several robots"])
def test_a_run_played_twice_is_the_same_and_every_part_of_it_is_hashed(case: Case) -> None:
    (before, trace), (now, again) = play(case), play(case)
    assert before == now
    assert trace.lines == again.lines
    assert set(now.hashes) == set(PARTS)
    calls = [line for line in trace.lines if line.stream == "calls"]
    assert {line.robot for line in calls} == set(range(1 if case is ONE else 2))
    assert any(line.text.startswith("estop(") for line in calls)
    assert any(line.text.startswith("emergency_stop(") for line in trace.lines)
    assert any("the operator pressed STOP" in line.text for line in trace.lines)


@pytest.mark.slow
def test_one_order_that_comes_otherwise_is_found_where_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before, _ = play(ONE)
    order = VirtualLink.lease

    def shorter(
        link: VirtualLink,
        permit: bool,
        pose_age_s: float = math.inf,
        ttl_s: float = 0.5,
        odometry: bool = False,
    ) -> None:
        late = 1.0 < link.loop.now_s < 1.15
        order(link, permit, pose_age_s, ttl_s - 0.1 if late else ttl_s, odometry)

    monkeypatch.setattr(VirtualLink, "lease", shorter)
    found = differences(before, *play(ONE))
    assert found[0].startswith("hardware_in_the_loop/stop/0: heard differ")
    assert 3 <= len(found) <= 2 + BLOCK
    assert any("heard: lease(message=Lease(ttl_s=0.4" in line for line in found[2:])


@pytest.mark.slow
def test_runs_that_are_kept_compare_as_the_same_until_a_line_says_something_else(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, runs = tmp_path / "runs", ["--only", ONE.name, "--seeds", "1"]
    assert main(["--keep", str(file), *runs]) == 0
    assert main(["--compare", str(file), *runs]) == 0
    assert "1 runs compared, 0 differ" in capsys.readouterr().out
    head, line = file.read_text().splitlines()
    other = json.loads(line)
    other["hashes"]["report"] = "0" * 12
    file.write_text(f"{head}\n{json.dumps(other)}\n")
    assert main(["--compare", str(file), *runs]) == 1
    said = capsys.readouterr().out
    assert f"{ONE.name}: report differ" in said
    assert "1 runs compared, 1 differ" in said


def test_every_configuration_and_every_trouble_is_among_the_runs_and_in_the_sample() -> None:
    cases = all_cases(seeds=2)
    assert len({one.name for one in cases}) == len(cases)
    assert {one.trouble for one in cases} == set(TROUBLES)
    quick = sample(cases)
    without_pictures = {name for name, one in TROUBLES.items() if one.without_pictures}
    assert {one.trouble for one in quick} == without_pictures
    configs = {one.config for one in cases}
    assert {one.config for one in quick if one.trouble == "none"} == configs
    assert {"simulation", "two_cameras", "fleet", "two_cameras_fleet"} <= configs
    assert not configs & {"epuck2", "real_camera"}, "these need real time, or a real camera"


def test_the_block_in_which_two_runs_part_is_found_and_a_longer_run_parts_at_its_end() -> None:
    before, now = Trace(), Trace()
    for trace, at_40 in ((before, "lease"), (now, "estop")):
        for number in range(60):
            trace.note("calls", 0, at_40 if number == 40 else "lease")
    assert first_difference(before.by_block(), now.by_block()) == 40 // BLOCK
    assert first_difference(before.by_block(), before.by_block()) is None
    assert "0.0 robot 0 calls: estop" in now.of_block(40 // BLOCK)
    longer = before.by_block()
    before.note("calls", 0, "close")
    assert first_difference(longer, before.by_block()) == 60 // BLOCK


def test_a_file_that_keeps_no_runs_is_refused_in_a_sentence(tmp_path: Path) -> None:
    file = tmp_path / "runs"
    file.write_text("hello\n")
    with pytest.raises(KeptError, match="not a file that --keep wrote"):
        read(file)
    with pytest.raises(KeptError, match="No such file"):
        read(tmp_path / "none")
