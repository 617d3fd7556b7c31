"""Every test of a configuration begins without the secrets that another one has read."""

from collections.abc import Iterator

import pytest

from navigation.config.secrecy import secrets
from navigation.config.secrecy.secrets import Redactor


@pytest.fixture(autouse=True)
def _nothing_is_known() -> Iterator[None]:
    before = secrets._known
    secrets._known = Redactor()
    yield
    secrets._known = before
