"""The configuration of a run: read, overridden from the environment, checked, then trusted.

- ``load.py`` reads the file in this order: ``secrecy`` learns the secrets, ``marks.py`` parses the
  YAML with its places, ``overrides.py`` applies the environment, and the sections and
  ``checks.py`` (with ``several`` for several robots or cameras) check it.
- ``sections.py``, ``simulation.py``, ``dashboard.py``, ``recording.py`` and ``zones`` are the
  sections, made of the kinds in ``values.py``; ``known_robots.py`` holds the vendors' numbers.
- ``zone_file.py`` reads zones that come in an order or a file of their own.
- ``errors.py`` words the problems; ``unknown_keys.py`` hides the values of unknown keys.
- ``limits.py`` gives the planner its limits; ``last_good.py`` keeps a good text.
- ``reference.py`` writes the reference and the first file; ``editing`` changes a text.
"""

from navigation.config.errors import ConfigError
from navigation.config.limits import limits_of
from navigation.config.load import load_config, parse_config
from navigation.config.sections import Config

__all__ = ["Config", "ConfigError", "limits_of", "load_config", "parse_config"]
