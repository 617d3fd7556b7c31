"""Importing Clearway replaces nothing in the packages of others, in any program that imports it."""

from __future__ import annotations

import json
import subprocess
import sys

from planner.shared.kernel_locator import ROOT

STRANGERS = (
    "cv2",
    "click",
    "fastapi",
    "h11",
    "llvmlite",
    "networkx",
    "numba",
    "numpy",
    "pydantic",
    "serial",
    "starlette",
    "uvicorn",
    "websockets",
    "yaml",
)
SETTINGS = {
    f"numba.core.config.{name}"
    for name in (
        "CACHE_DIR",
        "CACHE_LOCATOR_CLASSES",
        "CPU_FEATURES",
        "CPU_NAME",
        "DISABLE_TYPEINFER_FAIL_CACHE",
    )
}
"""Numba's own documented settings, which any program may set."""

LOAD_OURS = """
import importlib, pkgutil, sys
import firmware_protocol, navigation, planner, vision

for package in (planner, vision, navigation):
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
"""
LIST_STRANGERS = """
print(json.dumps([
    name for name, module in sys.modules.items()
    if module is not None and name.partition(".")[0] in strangers
]))
"""
COMPARE = """
import pydantic

def seen():
    found = {}
    for name, module in list(sys.modules.items()):
        if module is None or name.partition(".")[0] not in strangers or name not in known:
            continue
        for attribute, value in list(vars(module).items()):
            found[f"{name}.{attribute}"] = stamp(value)
            if isinstance(value, type) and value.__module__ == name:
                for own, inner in list(vars(value).items()):
                    found[f"{name}.{attribute}.{own}"] = stamp(inner)
    return found

def stamp(value):
    kept.append(value)  # or its id would be given to another
    if isinstance(value, (bool, int, float, str, bytes, type(None))):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return [id(value), *map(id, value)]
    return id(value)

kept = []
known = json.loads(sys.argv[1])
for name in known:
    try:
        importlib.import_module(name)
    except ImportError:  # made by another module, not found by its name
        pass
pydantic.create_model("First")  # pydantic looks for its plugins when a program makes a model
before = seen()
ours()
after = seen()
print(json.dumps([name for name, value in before.items() if after.get(name) != value]))
"""
HEAD = f"import importlib, json, sys\nstrangers = {STRANGERS!r}\n"


def run(code: str, *arguments: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", HEAD + code, *arguments],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return list(json.loads(done.stdout.splitlines()[-1]))


def changed_by(code: str) -> set[str]:
    """Attributes of modules and classes of others that differ after the code has run."""
    known = run(code + LIST_STRANGERS)
    indented = "\n".join(f"    {line}" for line in code.splitlines())
    return set(run(f"def ours():\n{indented}\n{COMPARE}", json.dumps(known)))


def test_no_attribute_of_another_package_is_replaced() -> None:
    assert changed_by(LOAD_OURS) - SETTINGS == set()


def test_a_replaced_method_and_a_longer_list_are_seen() -> None:
    """The comparison itself, on what an earlier version did to numba."""
    replace = """
from numba.core import caching, dispatcher
usual = dispatcher.Dispatcher.compile
dispatcher.Dispatcher.compile = lambda self, signature: usual(self, signature)
caching.CacheImpl._locator_classes.insert(0, None)
"""
    assert changed_by(replace) == {
        "numba.core.caching.CacheImpl._locator_classes",
        "numba.core.dispatcher.Dispatcher.compile",
    }
