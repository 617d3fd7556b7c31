"""The counts of the code, on small trees that are made up: each is counted by hand beside it."""

from __future__ import annotations

import ast
import json
import re
from itertools import pairwise
from pathlib import Path

import networkx as nx
import pytest

from benchmarks.house import counts
from benchmarks.house.__main__ import main
from benchmarks.house.constants import named_numbers
from benchmarks.house.drawing import drawn
from benchmarks.house.figures import unsourced
from benchmarks.house.files import page
from benchmarks.house.layers import laid_out
from benchmarks.house.tree import PACKAGES, File, read

ROOT = Path(__file__).parents[2]


def written(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        for folder in path.relative_to(root).parents:
            if folder != Path("."):
                (root / folder / "__init__.py").touch()
    return root


def function(name: str, lines: int) -> str:
    return f"def {name}():\n" + "    x = 1\n" * (lines - 1)


def kernel(name: str) -> str:
    return f"@njit(cache=True)\ndef {name}(p):\n    return p\n"


def test_a_function_is_as_long_as_from_its_def_to_its_last_line(tmp_path: Path) -> None:
    text = function("just", 80) + "@cache\n" + function("over", 81)
    text += "class A:\n    async def method(self):\n" + "        x = 1\n" * 80
    found = counts.long_functions(read(written(tmp_path, {"vision/a.py": text}), ["vision"]), 80)
    assert found == [
        "vision/a.py:82: over has 81 lines",
        "vision/a.py:164: method has 81 lines",
    ]


def test_folders_and_files_beyond_their_limits_are_named(tmp_path: Path) -> None:
    names = {f"vision/full/m{i}.py": "" for i in range(15)}  # and __init__.py
    names |= {f"vision/fits/m{i}.py": "" for i in range(14)}
    names |= {f"vision/fits/__pycache__/m{i}.py": "" for i in range(9)}
    names |= {"vision/long.py": "x = 1\n" * 401, "vision/short.py": "x = 1\n" * 400}
    files = read(written(tmp_path, names), ["vision"])
    assert counts.crowded_folders(files, 15) == ["vision/full: 16 Python files"]
    assert counts.long_files(files, 400) == ["vision/long.py: 401 lines"]


def test_short_files_are_listed_where_they_hold_a_kernel(tmp_path: Path) -> None:
    names = {"vision/a.py": kernel("a"), "vision/b.py": function("b", 3)}
    names["vision/c.py"] = kernel("c") + "# a line\n" * 37
    files = read(written(tmp_path, names), ["vision"])
    assert counts.short_kernel_files(files, 40) == ["vision/a.py: 3 lines"]


def test_the_page_of_files_has_each_file_s_first_sentence(tmp_path: Path) -> None:
    names = {
        "vision/a.py": '"""Finds a.py or ``b``, in\npixels. More.\n\nMost.\n"""\n',
        "vision/in/b.py": '"""Either | or: as it comes."""\n',
    }
    written(tmp_path, names)
    (tmp_path / "vision/in/__init__.py").write_text('"""What is in it."""\n')
    rows = page(read(tmp_path, ["vision"])).splitlines()
    assert rows[rows.index("## vision") :] == [
        *("## vision", "", "| file | what it does |", "|---|---|"),
        "| [`a.py`](../vision/a.py) | Finds a.py or `b`, in pixels |",
        *("", "### vision/in", "", "What is in it", "", "| file | what it does |", "|---|---|"),
        "| [`b.py`](../vision/in/b.py) | Either \\| or: as it comes |",
    ]


def test_every_arrow_of_the_picture_runs_downwards_and_no_boxes_overlap() -> None:
    graph = nx.DiGraph([("a", "b"), ("b", "c"), ("a", "c"), ("a", "d"), ("d", "e"), ("f", "e")])
    graph.add_edge("a", "e")
    graph.add_node("alone")
    widths = dict.fromkeys(graph, 60.0)
    layout = laid_out(graph, widths)
    row = {place: i for i, floor in enumerate(layout.floors) for place in floor}
    assert {name for name in row if isinstance(name, str)} == set(graph)
    drawn_arrows = {(arrow[0], arrow[-1]) for arrow in layout.arrows}
    assert drawn_arrows == {("a", "b"), ("b", "c"), ("a", "d"), ("d", "e"), ("f", "e")}
    for arrow in layout.arrows:
        assert [row[place] for place in arrow] == list(range(row[arrow[0]], row[arrow[-1]] + 1))
    for floor in layout.floors:
        sides = [(layout.x_px[p] - 30.0, layout.x_px[p] + 30.0) for p in floor if p in widths]
        assert all(a[1] < b[0] for a, b in pairwise(sides))
        assert all(left >= 0.0 and right <= layout.width_px for left, right in sides)


def test_the_command_ends_with_1_where_a_limit_is_broken(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = (*PACKAGES, "tests", "benchmarks")
    written(tmp_path, {f"{folder}/__init__.py": "" for folder in folders})
    long = tmp_path / "planner/long.py"
    long.write_text("x = 1\n" * 401)
    assert main(["--root", str(tmp_path), "--list"]) == 1
    told = capsys.readouterr().out
    assert "| files above 400 lines | 1 | 0 | no |" in told
    assert "- planner/long.py: 401 lines" in told
    long.write_text("")
    assert main(["--root", str(tmp_path), "--format", "json"]) == 0
    assert all(one["holds"] and one["found"] == [] for one in json.loads(capsys.readouterr().out))


# The repository.


@pytest.fixture(scope="module")
def shipped() -> list[File]:
    return read(ROOT, PACKAGES)


def test_the_picture_of_the_folders_is_what_the_imports_are() -> None:
    picture = (ROOT / "docs/pictures/folders.svg").read_text()
    assert picture == drawn(PACKAGES), "make pictures draws it again"


def defined(path: Path) -> set[str]:
    """Functions of a file as a reader calls them: ``function``, ``Class.method``; in C any."""
    if path.suffix == ".c":
        return set(re.findall(r"^\w[\w *]*?(\w+)\(", path.read_text(), re.M))
    found = set()
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.ClassDef):
            methods = (one for one in node.body if isinstance(one, ast.FunctionDef))
            found |= {f"{node.name}.{method.name}" for method in methods}
    return found


def test_every_function_of_the_code_path_is_where_the_document_says() -> None:
    text = " ".join((ROOT / "docs/architecture.md").read_text().split())
    steps = re.findall(r"`([\w.]+)\(\)` in `([\w/]+\.(?:py|c))`", text)
    assert len(steps) > 40
    for name, file in steps:
        assert name in defined(ROOT / file), f"{file} has no {name}()"
    summed_up = text[text.index("The code path of a frame is") : text.index("### Camera to")]
    short = set(re.findall(r"`([\w.]+)\(\)`", summed_up))
    assert short <= {name for name, _ in steps}, short - {name for name, _ in steps}


def test_named_numbers_are_counted_with_the_word_for_their_source(tmp_path: Path) -> None:
    text = (
        "import math\n"
        'A = 3.0\n"""What noise has: derived, three times sigma."""\n'
        'B, C = 1, 2\n"""Kinds: defined."""\n'
        "# chosen, a pixel\nD = math.radians(2.0)\n"
        "E: float = 4.0  # Measured: 3.9 to 4.1\n"
        'F = 5\n"""How far it is measured along."""\n'
        'NAMES = "none"\nG = A\nnot_named = 4\n'
    )
    found = list(named_numbers(read(written(tmp_path, {"vision/a.py": text}), ["vision"])))
    assert {one.name: one.source for one in found} == {
        "A": "derived",
        "B": "defined",
        "C": "defined",
        "D": "chosen",
        "E": "measured",
        "F": "",
    }
    assert [one.name for one in found if one.tuned] == ["D", "E", "F"]
    assert str(found[-1]) == "vision/a.py:9: F (no source)"


def test_every_named_number_of_binarisation_and_outlines_has_its_source(
    shipped: list[File],
) -> None:
    assert [str(one) for one in unsourced(shipped)] == []
