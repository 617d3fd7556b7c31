"""Every example runs as a person would run it, and leaves its picture."""

import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from subprocess import PIPE

import cv2
import nbformat
import pytest

from tests.examples.notebooks import (
    code_cells,
    executed,
    kinds_of,
    text_of,
    words_and_numbers,
)
from tests.support.oracles.nav2_graph import load_graph
from tests.support.processes.forked import Program

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
PICTURES = dict(
    re.findall(r"^\| \[`([\w.]+)`\].*\| `([\w.]+)` \|$", (EXAMPLES / "README.md").read_text(), re.M)
)
"""Which picture each example makes, as its README says."""
SCRIPTS = sorted(name for name in PICTURES if name.endswith(".py"))
NOTEBOOKS = sorted(name for name in PICTURES if name.endswith(".ipynb"))
COLD_S = 900
"""Time limit of one example on a machine without compiled kernels, seconds."""
MOST_BYTES = 500 * 1024
AGREES = 0.05
"""Another processor rounds otherwise, and a simulated run repeats itself only on equal ones."""


def test_the_readme_lists_every_example() -> None:
    there = {f.name for f in EXAMPLES.iterdir() if f.suffix in (".py", ".ipynb")}
    assert set(PICTURES) == there


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Runs a script, once however many tests ask for it; the folder with what it left."""

    @cache
    def made(name: str) -> Path:
        folder = tmp_path_factory.mktemp("made")
        program = Program([folder], file=EXAMPLES / name, cwd=folder, stdout=PIPE, stderr=PIPE)
        out, err = program.communicate(COLD_S - 20)
        assert program.returncode == 0, err
        assert out
        assert not err
        return folder

    return made


@pytest.mark.timeout(COLD_S)
@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_runs_and_leaves_its_picture(name: str, made: Callable[[str], Path]) -> None:
    _is_a_picture(made(name) / PICTURES[name])


@pytest.mark.parametrize("name", NOTEBOOKS)
@pytest.mark.timeout(COLD_S)
# the notebook's kernel, and the client's own threads, leave sockets to the end of the process
@pytest.mark.filterwarnings("default")
def test_a_notebook_puts_out_what_is_committed_and_leaves_its_picture(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.delenv("MPLBACKEND", raising=False)
    committed = code_cells(nbformat.read(EXAMPLES / name, as_version=4))
    fresh = code_cells(executed(EXAMPLES / name, tmp_path))
    _is_a_picture(tmp_path / PICTURES[name])
    for kept, now in zip(committed, fresh, strict=True):
        assert kinds_of(kept) == kinds_of(now), kept.source
        words, numbers = words_and_numbers(text_of(kept))
        words_now, numbers_now = words_and_numbers(text_of(now))
        assert words == words_now, kept.source
        assert numbers == pytest.approx(numbers_now, rel=AGREES, abs=AGREES), kept.source


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_is_committed_with_its_outputs(name: str) -> None:
    """Where this fails: `python -m tests.examples.notebooks`."""
    assert (EXAMPLES / name).stat().st_size < MOST_BYTES
    cells = code_cells(nbformat.read(EXAMPLES / name, as_version=4))
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    assert sum(bool(text_of(cell)) for cell in cells) >= 3
    assert not [output for output in outputs if output.output_type == "error"]
    text = json.dumps([output.get("text", output.get("data", {})) for output in outputs])
    assert not re.search(r"/(home|root|tmp|work|usr)/", text), "a path of one machine"


@pytest.mark.timeout(COLD_S)
def test_nav2_reads_the_route_graph(made: Callable[[str], Path]) -> None:
    nodes = load_graph((made("ros_map_to_nav2.py") / "route_graph.geojson").read_text())
    assert nodes
    assert all(node.leaving for node in nodes.values())


def _is_a_picture(file: Path) -> None:
    if file.suffix == ".svg":
        text = file.read_text()
        assert text.startswith("<svg")
        assert text.count("<path") > 3
        return
    picture = cv2.imread(str(file))
    assert picture is not None, f"{file} is no picture"
    assert picture.std() > 10.0, f"{file} is empty"
