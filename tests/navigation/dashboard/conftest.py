"""Dashboards for the tests: one that nobody changes, one of its own, one behind tokens."""

from collections.abc import Iterator

import pytest

from tests.navigation.dashboard.site import TOKEN, VIEWER, Site
from tests.support.runs.shown import FakeDaemon, laboratory, shown_config


@pytest.fixture(scope="module")
def quiet_site() -> Iterator[Site]:
    """One site for tests that leave nothing behind."""
    with Site(FakeDaemon(roadmap=laboratory())) as site:
        yield site


@pytest.fixture
def site() -> Iterator[Site]:
    with Site(FakeDaemon(roadmap=laboratory())) as site:
        yield site


@pytest.fixture
def guarded() -> Iterator[Site]:
    """A site with tokens."""
    with Site(FakeDaemon(shown_config(token=TOKEN, viewer_token=VIEWER))) as site:
        yield site
