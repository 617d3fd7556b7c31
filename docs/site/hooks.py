"""What the documentation site checks and adapts while MkDocs builds it.

- A page of every source file is made of the first sentences of their docstrings.
- A public name (in a package's ``__init__.pyi``, or its ``__all__``) that no reference page
  documents stops the build.
- A link from a page to a file of the repository outside ``docs/`` has to exist; the site has no
  such page, so that the link becomes plain text.
- Roles such as ``:func:`name``` in docstrings become plain code.
"""

from __future__ import annotations

import ast
import os.path
import re
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

from benchmarks.house.files import page as page_of_files
from benchmarks.house.tree import read

ROOT = Path(__file__).parents[2]
PACKAGES = ("vision", "planner", "firmware_protocol", "navigation")
_LINK = re.compile(r"(?<!!)\[((?:[^\[\]]|\[[^\]]*\])+)\]\((\.\./[^)\s#]+)(#[^)\s]*)?\)")
_ROLE = re.compile(r":(?:class|data|func|meth|mod):(<code>)[.~]*")


def public_names(package: str, root: Path = ROOT) -> list[str]:
    """Names that the package's stub or its ``__all__`` lists, read without importing it."""
    stub = root / package / "__init__.pyi"
    if stub.exists():
        imports = ast.parse(stub.read_text(encoding="utf-8")).body
        return sorted(name.name for line in imports for name in getattr(line, "names", ()))
    tree = ast.parse((root / package / "__init__.py").read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(
            isinstance(target, ast.Name) and target.id == "__all__" for target in node.targets
        ):
            return list(ast.literal_eval(node.value))
    return []


def undocumented(root: Path = ROOT) -> list[str]:
    """The public names that no page in docs/reference has a ``:::`` entry for."""
    pages = sorted((root / "docs/reference").glob("*.md"))
    entries = {
        found
        for page in pages
        for found in re.findall(r"^::: (\S+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    }
    names = [f"{package}.{name}" for package in PACKAGES for name in public_names(package, root)]
    return [name for name in names if name not in entries]


def on_pre_build(**_: Any) -> None:
    """Stop where the reference is not complete."""
    if missing := undocumented():
        raise PluginError(f"docs/reference documents no {', '.join(missing)}: add `::: NAME`")


def on_files(files: Files, *, config: Any) -> None:
    """The page of every source file."""
    content = page_of_files(read(ROOT, PACKAGES))
    files.append(File.generated(config, "files.md", content=content))


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Links into the repository: checked, then shown as text."""

    def without_link(found: re.Match[str]) -> str:
        target = os.path.normpath(Path("docs", page.file.src_uri).parent / found[2])
        if target.startswith("docs/"):
            return found[0]
        if not (ROOT / target).exists():
            raise PluginError(f"{page.file.src_uri}: links to {found[2]}, which does not exist")
        return found[1]

    return _LINK.sub(without_link, markdown)


def on_page_content(html: str, **_: Any) -> str:
    """Docstrings' roles as plain code."""
    return _ROLE.sub(r"\1", html)
