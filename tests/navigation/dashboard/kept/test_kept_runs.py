"""Earlier runs: what is listed, what is given, and that nothing else on the disk ever is."""

import json
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from navigation.config import Config
from navigation.dashboard import KeptRuns
from navigation.dashboard.kept.answers import PIECE_BYTES
from navigation.dashboard.kept.runs import is_recording, is_run
from tests.navigation.dashboard.site import TOKEN, VIEWER, Site
from tests.support.runs.shown import FakeDaemon, shown_config

RUN = "2026-03-04_05-06-07"
LATER = "2026-03-04_05-06-07_2"
NEWEST = "2026-03-05_00-00-00"
TAPE = "clearway_2026-03-04_05-06-09_001.mcap"


def keep(config: Config, folder: Path) -> Config:
    recording = config.recording.model_copy(
        update={"runs_dir": folder / "runs", "folder": folder / "recordings"}
    )
    return config.model_copy(update={"recording": recording})


def fill(folder: Path) -> None:
    """Three runs: one with everything, one under way, one that was ended by force."""
    for name in (RUN, LATER, NEWEST):
        (folder / "runs" / name).mkdir(parents=True)
        (folder / "runs" / name / "events.jsonl").write_text('{"event": "ready"}\n')
    report = {"state": "done", "reason": "there", "duration_s": 12.5}
    (folder / "runs" / RUN / "report.json").write_text(json.dumps(report))
    (folder / "runs" / RUN / "track.svg").write_text("<svg/>")
    (folder / "runs" / RUN / "secret.txt").write_text("not a run's")
    (folder / "runs" / "notes").mkdir()
    (folder / "recordings").mkdir()
    (folder / "recordings" / TAPE).write_bytes(bytes(range(256)) * 4096)
    (folder / "recordings" / "other.mcap").write_bytes(b"somebody else's")
    (folder / "secret.txt").write_text("outside")


@pytest.fixture
def kept_site(tmp_path: Path) -> Iterator[Site]:
    fill(tmp_path)
    with Site(FakeDaemon(keep(shown_config(), tmp_path))) as site:
        yield site


def fetch(site: Site, path: str, **headers: str) -> tuple[int, bytes, dict[str, str]]:
    request = urllib.request.Request(f"http://{site.address}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status, answer.read(), {k.lower(): v for k, v in answer.headers.items()}
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read(), {k.lower(): v for k, v in error.headers.items()}


def test_runs_are_listed_newest_first_with_what_each_left(kept_site: Site) -> None:
    _, text, _ = kept_site.get("/api/runs")
    page = json.loads(text)
    assert [run["name"] for run in page["runs"]] == [NEWEST, LATER, RUN]
    assert (page["total"], page["following"]) == (3, False)
    newest, later, first = page["runs"]
    assert (newest["state"], newest["duration_s"], newest["running"]) == (None, None, False)
    assert [file["name"] for file in newest["files"]] == ["events.jsonl"]
    assert (first["state"], first["reason"], first["duration_s"]) == ("done", "there", 12.5)
    assert first["robots"] == []
    assert {f["name"]: f["bytes"] for f in first["files"]}["track.svg"] == len("<svg/>")
    tapes = [{"name": TAPE, "bytes": 256 * 4096}]
    assert (newest["recordings"], later["recordings"], first["recordings"]) == ([], tapes, [])


def test_many_runs_come_in_pages(tmp_path: Path) -> None:
    names = [f"2026-01-{day:02d}_12-00-00" for day in range(1, 32)]
    for name in names:
        (tmp_path / name).mkdir()
    runs = KeptRuns(tmp_path, tmp_path / "none", running=names[-1])
    seen: list[str] = []
    before = None
    while True:
        page = runs.page(before, 10)
        assert page.total == 31
        assert [run.is_running for run in page.runs] == [r.name == names[-1] for r in page.runs]
        seen += [run.name for run in page.runs]
        before = seen[-1]
        if not page.following:
            break
    assert seen == sorted(names, reverse=True)


def test_ten_runs_of_one_second_stay_in_order(tmp_path: Path) -> None:
    names = [RUN, *(f"{RUN}_{number}" for number in range(2, 12))]
    for name in names:
        (tmp_path / name).mkdir()
    page = KeptRuns(tmp_path, tmp_path).page(f"{RUN}_11", 20)
    assert [run.name for run in page.runs] == names[-2::-1]


def test_a_file_comes_whole_and_a_large_one_in_pieces(kept_site: Site) -> None:
    status, body, headers = fetch(kept_site, f"/api/runs/{RUN}/report.json")
    assert (status, json.loads(body)["state"]) == (200, "done")
    assert headers["content-disposition"] == 'attachment; filename="report.json"'
    assert headers["content-security-policy"].startswith("default-src 'none'")
    address = f"/api/runs/{LATER}/{TAPE}"
    status, body, _ = fetch(kept_site, address)
    assert status == 413
    assert b"Range" in body
    whole = b""
    while len(whole) < 256 * 4096:
        status, piece, headers = fetch(kept_site, address, Range=f"bytes={len(whole)}-")
        assert status == 206
        assert 0 < len(piece) <= PIECE_BYTES
        last = len(whole) + len(piece) - 1
        assert headers["content-range"] == f"bytes {len(whole)}-{last}/{256 * 4096}"
        whole += piece
    assert whole == bytes(range(256)) * 4096
    assert fetch(kept_site, address, Range=f"bytes={256 * 4096}-")[0] == 416
    assert fetch(kept_site, address, Range="bytes=9-3")[0] == 416
    assert fetch(kept_site, address, Range="bytes=3-5")[1] == bytes([3, 4, 5])


@pytest.mark.parametrize(
    "path",
    [
        f"/api/runs/{RUN}/secret.txt",
        f"/api/runs/{RUN}/../secret.txt",
        f"/api/runs/{RUN}/..%2f..%2fsecret.txt",
        f"/api/runs/..%2f{RUN}/report.json",
        "/api/runs/../secret.txt",
        "/api/runs/%2e%2e/secret.txt",
        "/api/runs/notes/report.json",
        "/api/runs/2026-13-04_05-06-07/report.json",
        f"/api/runs/{RUN}/other.mcap",
        f"/api/runs/{RUN}/report.json%00.svg",
        f"/api/runs/{RUN}%0a/report.json",
        f"/api/runs/{NEWEST}/report.json",
        f"/api/runs//{RUN}/report.json",
        "/api/runs/%ff/report.json",
    ],
)
def test_nothing_but_files_of_runs_is_given(kept_site: Site, path: str) -> None:
    status, body, _ = fetch(kept_site, path)
    assert status == 404
    assert b"outside" not in body


def test_links_lead_nowhere(tmp_path: Path) -> None:
    fill(tmp_path)
    (tmp_path / "runs" / NEWEST / "report.json").symlink_to(tmp_path / "secret.txt")
    (tmp_path / "runs" / "2026-04-01_00-00-00").symlink_to(tmp_path / "runs" / RUN)
    (tmp_path / "recordings" / "clearway_2026-03-04_05-06-10_001.mcap").symlink_to(
        tmp_path / "secret.txt"
    )
    (tmp_path / "recordings" / "clearway_2026-03-04_05-06-10_002.mcap").mkdir()
    runs = KeptRuns(tmp_path / "runs", tmp_path / "recordings")
    page = runs.page(None, 50)
    assert [run.name for run in page.runs] == [NEWEST, LATER, RUN]
    assert [file.name for file in page.runs[0].files] == ["events.jsonl"]
    assert [file.name for file in page.runs[1].recordings] == [TAPE]
    for run, file in (
        (NEWEST, "report.json"),
        ("2026-04-01_00-00-00", "report.json"),
        (RUN, "clearway_2026-03-04_05-06-10_001.mcap"),
        (RUN, "clearway_2026-03-04_05-06-10_002.mcap"),
    ):
        with pytest.raises(OSError), runs.opened(run, file):  # noqa: PT011 (any of its kinds)
            pass


def test_a_report_that_cannot_be_read_is_none(tmp_path: Path) -> None:
    fill(tmp_path)
    for text in (
        "{",
        "[1]",
        "[" * 100_000,
        '{"state": 7, "duration_s": "x"}',
        '{"duration_s": NaN}',
    ):
        (tmp_path / "runs" / NEWEST / "report.json").write_text(text)
        with Site(FakeDaemon(keep(shown_config(), tmp_path))) as site:
            run = json.loads(site.get("/api/runs?count=1")[1])["runs"][0]
            assert (run["name"], run["state"], run["duration_s"]) == (NEWEST, None, None)


def test_a_report_with_half_a_surrogate_hides_no_other_run(tmp_path: Path) -> None:
    fill(tmp_path)
    (tmp_path / "runs" / LATER / "report.json").write_text('{"state": "\\ud800"}')
    with Site(FakeDaemon(keep(shown_config(), tmp_path))) as site:
        status, body, _ = fetch(site, "/api/runs")
    assert status == 200
    told = {one["name"]: one for one in json.loads(body)["runs"]}
    assert set(told) == {RUN, LATER, NEWEST}


def test_they_need_the_token_that_the_page_needs(tmp_path: Path) -> None:
    fill(tmp_path)
    config = keep(shown_config(token=TOKEN, viewer_token=VIEWER), tmp_path)
    with Site(FakeDaemon(config)) as site:
        for path in ("/api/runs", f"/api/runs/{RUN}/report.json"):
            assert fetch(site, path)[0] == 401
            assert fetch(site, path, Authorization="Bearer wrong-wrong-wrong")[0] == 403
            assert fetch(site, path, Authorization=f"Bearer {VIEWER}")[0] == 200
            assert fetch(site, path, Host="elsewhere.example")[0] == 400


@pytest.mark.parametrize(
    "query", ["before=../x", "before=", "count=0", "count=51", "count=x", "count=-1", "count=%F0"]
)
def test_a_question_that_makes_no_sense_is_refused(kept_site: Site, query: str) -> None:
    assert fetch(kept_site, f"/api/runs?{query}")[0] == 400


@pytest.mark.parametrize("name", [RUN, LATER, f"{RUN}_999"])
def test_names_of_runs(name: str) -> None:
    assert is_run(name)
    assert not is_recording(name)
    assert not is_run(name + "\n")
    assert not is_run("x" + name)


def test_no_folder_is_no_runs(tmp_path: Path) -> None:
    page = KeptRuns(tmp_path / "a", tmp_path / "b").page(None, 5)
    assert (page.runs, page.total, page.following) == ((), 0, False)
