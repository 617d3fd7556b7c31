"""No secret of a configuration leaves the program: every byte that goes out is looked through.

The real program runs with a network camera that is there, then lost, and a port on the network
that is not there; secrets stand in every place where a person may put them.
"""

from __future__ import annotations

import base64
import json
import os
import re
import signal
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import PIPE
from zipfile import ZipFile

import pytest
from mcap.reader import make_reader
from websockets.sync.client import connect

from tests.support.processes.forked import Program
from tests.support.processes.mjpeg_server import mjpeg_server
from tests.support.waiting import wait_until
from vision.calibration.calibration import Calibration
from vision.calibration.calibration_file import calibration_text

pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[2] / "configs"
WITHIN_S = 90.0
MARK = "zq7"
"""In every secret, and in nothing else."""
USER, PASSWORD = f"{MARK}user", f"{MARK}pass%2Fword"
QUERY = f"token={MARK}query&t={MARK}second;{MARK}naked"
TOKEN, VIEWER = f"{MARK}-token-of-the-environment", f"{MARK}-token-for-looking"
ENVIRONMENT = {**os.environ, "CLEARWAY_DASHBOARD__TOKEN": TOKEN}
MISTYPED = f"\ndashbord: {{tokn: {MARK}mistyped, colour: {MARK}unknown}}\n"
NEEDLES = (
    MARK.encode(),
    base64.b64encode(f"{USER}:{PASSWORD}".encode()),
    base64.b64encode(f"{USER}:{MARK}pass/word".encode()),
)


def leaks(text: str | bytes) -> list[str]:
    """The surroundings of every secret in it."""
    data = text.encode() if isinstance(text, str) else text
    places = [m.start() for one in NEEDLES for m in re.finditer(re.escape(one), data)]
    return [data[max(0, at - 60) : at + 40].decode(errors="replace") for at in places]


def configuration(folder: Path, address: str) -> Path:
    """A camera at ``address`` and a port on the network, with secrets everywhere."""
    text = (CONFIGS / "real_camera.yaml").read_text()
    host = address.removeprefix("http://")
    source = f"http://{USER}:{PASSWORD}@{host}?{QUERY}#{MARK}fragment"
    changes = {
        "source: 0 ": f"source: '{source}' ",
        "size_px: [1280, 960]": "size_px: [64, 48]",
        "simulation_calibration.yaml": "small.yaml",
        "robot:": "robot:\n  driver: waveshare",
        "radius_m: 0.09": "radius_m: 0.16",
        "marker_size_m: 0.09": "marker_size_m: 0.22",  # six pixels
        "port: /dev/ttyUSB0": f"port: rfc2217://{USER}:{MARK}port@127.0.0.1:1",
    }
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new, 1)
    text += f"""  record: true
  folder: recordings
dashboard:
  port: 0
  token: {MARK}-token-of-the-file    # before that: password {MARK}comment
  viewer_token: {VIEWER}
  supervisor_token: {MARK}-token-of-a-teacher
notify:
  url: http://127.0.0.1:1/{MARK}hook/{MARK}key
"""
    calibration = Calibration.from_scale(2.4 / 64, (64, 48), (0.0, 0.0, 2.0))
    (folder / "small.yaml").write_text(calibration_text(calibration))
    file = folder / "secret.yaml"
    file.write_text(text)
    return file


class Running:
    """`clearway run` with its two outputs in files."""

    def __init__(self, file: Path, log_format: str) -> None:
        self.folder = file.parent
        self.out, self.err = self.folder / "run.stdout", self.folder / "run.stderr"
        words = ["run", file.name, "--socket", "private/c.sock", "--log-format", log_format]
        words += ["--log-level", "debug"]
        environment = {**ENVIRONMENT, "XDG_STATE_HOME": str(self.folder / "state")}
        with self.out.open("wb") as out, self.err.open("wb") as err:
            self.process = Program(words, cwd=self.folder, env=environment, stdout=out, stderr=err)

    def says(self, pattern: str) -> str:
        """Wait until it says that; the last such place."""
        found: list[str] = []

        def is_said() -> bool:
            found[:] = re.findall(pattern, self.out.read_text() + self.err.read_text())
            return bool(found) or self.process.poll() is not None

        wait_until(is_said, WITHIN_S)
        assert found, self.out.read_text() + self.err.read_text()
        return found[-1]


@contextmanager
def running(file: Path, log_format: str) -> Iterator[Running]:
    run = Running(file, log_format)
    try:
        yield run
    finally:
        if run.process.poll() is None:
            run.process.kill()
        run.process.wait()


def command(folder: Path, *words: str) -> bytes:
    """Both outputs of a command of the program."""
    environment = {**ENVIRONMENT, "XDG_STATE_HOME": str(folder / "state")}
    program = Program(words, cwd=folder, env=environment, stdout=PIPE, stderr=PIPE)
    out, err = program.communicate(WITHIN_S)
    assert "Traceback" not in err, err
    return (out + err).encode()


def fetched(address: str, path: str) -> bytes:
    """What the page is answered, in pieces where it is long."""
    whole = b""
    while True:
        headers = {"Authorization": f"Bearer {TOKEN}", "Range": f"bytes={len(whole)}-"}
        request = urllib.request.Request(f"http://{address}{path}", headers=headers)
        with urllib.request.urlopen(request, timeout=WITHIN_S) as answer:
            whole += answer.read()
            size = str(answer.headers.get("content-range", "")).rpartition("/")[2]
        if not size or len(whole) >= int(size):
            return whole


def on_the_page(address: str) -> Iterator[tuple[str, bytes]]:
    """What everybody who has the token is told, by where: the page's socket, and every address."""
    with connect(f"ws://{address}/live", subprotocols=["clearway.1", f"token.{TOKEN}"]) as line:  # type: ignore[list-item]
        line.send(json.dumps({"type": "join", "key": "0123456789abcdef", "name": "a"}))
        line.send(json.dumps({"type": "order", "id": 1, "order": "stop"}))
        for number in range(30):
            told = line.recv(WITHIN_S)
            yield f"message {number}", told.encode() if isinstance(told, str) else told
    for path in ("/api/state", "/metrics", "/healthz", "/api/settings", "/api/runs"):
        yield path, fetched(address, path)
    for run in json.loads(fetched(address, "/api/runs"))["runs"]:
        for file in (*run["files"], *run["recordings"]):
            path = f"/api/runs/{run['name']}/{file['name']}"
            yield path, fetched(address, path)


def in_files(folder: Path) -> Iterator[tuple[str, bytes]]:
    """Every file that was written, messages of recordings as they are when they are unpacked."""
    for file in sorted(folder.rglob("*")):
        if not file.is_file() or file.name == "secret.yaml":
            continue
        if "state" in file.parts and file.suffix == ".yaml":
            assert file.stat().st_mode & 0o077 == 0  # the last good configuration, its owner's
            continue
        yield str(file), file.read_bytes()
        if file.suffix == ".mcap":
            with file.open("rb") as stream:
                for _, channel, message in make_reader(stream).iter_messages():
                    yield f"{file} {channel.topic}", message.data


def from_commands(folder: Path, file: Path) -> Iterator[tuple[str, bytes]]:
    """What the commands say that read a configuration or a recording."""
    for form in ("text", "json"):
        yield f"check {form}", command(folder, "check", file.name, "--format", form)
        yield f"doctor {form}", command(folder, "doctor", file.name, "--format", form)
    yield "bundle", command(folder, "doctor", file.name, "--bundle", "b.zip")
    with ZipFile(folder / "b.zip") as archive:
        for name in archive.namelist():
            yield f"bundle's {name}", archive.read(name)
    for recording in (folder / "recordings").glob("*.mcap"):
        yield "replay", command(folder, "replay", str(recording), "--format", "json")


@pytest.mark.parametrize("log_format", ["text", "json"])
def test_no_byte_that_leaves_the_program_is_of_a_secret(tmp_path: Path, log_format: str) -> None:
    found: dict[str, list[str]] = {}

    def look(what: str, data: bytes) -> None:
        found.update({what: leaks(data)} if leaks(data) else {})

    with mjpeg_server() as camera:
        file = configuration(tmp_path, camera.url)
        with running(file, log_format) as run:
            address = run.says(r"http://(127\.0\.0\.1:\d+)")
            run.says("rfc2217")
            assert wait_until(lambda: any(tmp_path.glob("recordings/*.mcap")), WITHIN_S)
            camera.mode = "lost"
            run.says(r"stream\.mjpg")
            good = file.read_text()
            file.write_text(good + MISTYPED)
            run.process.send_signal(signal.SIGHUP)
            run.says("tokn|dashbord")
            for form in ("text", "json"):
                words = ("status", "--socket", "private/c.sock", "--format", form)
                look(f"status {form}", command(tmp_path, *words))
            look("check of a mistyped key", command(tmp_path, "check", file.name))
            file.write_text(good)
            for what, data in on_the_page(address):
                look(what, data)
            run.process.send_signal(signal.SIGTERM)
            run.process.wait(WITHIN_S)
        # the run's log has no part in the commands' answers: one of its forms is enough
        answers = from_commands(tmp_path, file) if log_format == "text" else ()
        for what, data in (*answers, *in_files(tmp_path)):
            look(what, data)
    names = {file.name for file in tmp_path.rglob("*")}
    assert {"report.json", "events.jsonl", "run.stdout"} <= names
    assert ("b.zip" in names) == (log_format == "text")
    assert any(name.endswith(".mcap") for name in names)
    assert found == {}, json.dumps(found, indent=1)
