"""The configuration of a run: read, overridden from the environment, checked, then trusted.

- `load` reads the file in this order: `secrecy` learns the secrets, `marks` parses the YAML with
  its places, `overrides` applies the environment, and the sections and `checks` (with `several` for
  several robots or cameras) check it.
- `sections`, `simulation`, `dashboard`, `recording`, `notify` and `zones` are the sections, made of
  the kinds in `values`; `known_robots` holds the vendors' numbers.
- `zone_file` reads zones that come in an order or a file of their own.
- `errors` words the problems; `unknown_keys` finds values to hide.
- `limits` gives the planner its limits; `last_good` keeps a good text.
- `reference` writes the reference and the first file; `editing` changes a text.
"""

from navigation.config.errors import ConfigError
from navigation.config.limits import limits_of
from navigation.config.load import load_config, parse_config
from navigation.config.sections import Config

__all__ = ["Config", "ConfigError", "limits_of", "load_config", "parse_config"]
