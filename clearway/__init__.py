"""The names that most programs need, from the packages that have them.

``__init__.pyi`` lists them; they are imported on first use. ``vision``, ``planner``,
``navigation`` and ``firmware_protocol`` have all others.
"""

from importlib.metadata import version

import lazy_loader

__version__ = version("clearway")

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
