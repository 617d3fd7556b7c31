"""The garbage collector leaves imports alone, and then searches as it always does."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from navigation.shared.garbage import IMPORTED, USUAL, postpone_collection, resume_collection


@pytest.fixture(autouse=True)
def collector_as_before() -> Iterator[None]:
    callbacks = list(gc.callbacks)
    gc.disable()  # no search but those of the tests
    yield
    gc.callbacks[:] = callbacks
    gc.set_threshold(*USUAL)
    gc.unfreeze()
    gc.enable()


def test_the_first_search_waits_for_the_imports() -> None:
    postpone_collection()
    assert gc.get_threshold() == (IMPORTED, *USUAL[1:])


def test_after_it_the_collector_works_as_usual_without_what_there_was() -> None:
    postpone_collection()
    gc.collect()
    assert gc.get_threshold() == USUAL
    assert gc.get_freeze_count() > 10_000


def test_resuming_does_not_search() -> None:
    searches: list[str] = []
    gc.callbacks.append(lambda phase, _: searches.append(phase))
    postpone_collection()
    resume_collection()
    assert (gc.get_threshold(), searches) == (USUAL, [])
    assert gc.get_freeze_count() > 10_000


def test_a_program_that_postponed_nothing_keeps_its_collector() -> None:
    gc.set_threshold(123)
    resume_collection()
    assert gc.get_threshold()[0] == 123
    assert gc.get_freeze_count() == 0
