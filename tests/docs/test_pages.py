"""The documentation's examples run, and its reference is complete."""

import importlib
import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from tests.docs.fences import Example, compare, examples_in, run_page

ROOT = Path(__file__).parents[2]
PAGES = [
    *sorted((ROOT / "docs/reference").glob("*.md")),
    *sorted((ROOT / "docs/how_to").glob("*.md")),
    ROOT / "docs/tutorial.md",
]


@pytest.mark.timeout(900)  # on a machine that has no compiled kernels yet
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_examples_of_a_page_print_what_it_states(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run_page(page)


@pytest.mark.parametrize("package", ["vision", "planner", "firmware_protocol", "navigation"])
def test_every_public_name_has_an_example(package: str) -> None:
    """An entry without a python block below it documents no use."""
    names = list(importlib.import_module(package).__all__)
    page = (ROOT / f"docs/reference/{package}.md").read_text(encoding="utf-8")
    entries = page.split("\n::: ")[1:]
    shown = {entry.split("\n", 1)[0]: entry for entry in entries}
    assert sorted(shown) == sorted(f"{package}.{name}" for name in names)
    together = ["navigation.SimulatedRobot"]  # the link's example, right below, is its own
    for name, entry in shown.items():
        assert "```python" in entry or name in together, f"{name} has no example"


def _hooks() -> ModuleType:
    spec = importlib.util.spec_from_file_location("site_hooks", ROOT / "docs/site/hooks.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_build_names_a_public_name_without_an_entry(tmp_path: Path) -> None:
    for package in ("vision", "planner", "firmware_protocol", "navigation"):
        (tmp_path / package).mkdir()
        text = '__all__ = ["seen", "missing"]\n' if package == "planner" else ""
        (tmp_path / package / "__init__.py").write_text(text)
    (tmp_path / "docs/reference").mkdir(parents=True)
    (tmp_path / "docs/reference/planner.md").write_text("# planner\n\n::: planner.seen\n")
    hooks = _hooks()
    assert hooks.undocumented(tmp_path) == ["planner.missing"]
    assert hooks.undocumented() == []


def test_a_block_s_output_is_the_text_right_below_it() -> None:
    page = (
        "```python\nprint(1)\n```\n\n```text\n1\n```\n\n"
        "```python\nprint(2)\n```\n\nWords.\n\n```text\n3\n```\n"
    )
    assert list(examples_in(page)) == [
        Example("python", "print(1)\n", "1\n", 2),
        Example("python", "print(2)\n", None, 10),
    ]


def test_output_that_differs_is_an_error() -> None:
    compare("here", "a ... c\n", "a b c\n")
    with pytest.raises(AssertionError, match="here: the page states"):
        compare("here", "a\n", "b\n")


def test_every_page_is_in_the_site_s_navigation() -> None:
    docs = ROOT / "docs"
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    pages = {page.relative_to(docs).as_posix() for page in docs.rglob("*.md")}
    made = {"files.md"}  # while the site is built
    assert pages ^ set(re.findall(r"\S+\.md", navigation)) == made
