"""The configuration of a run: read, overridden from the environment, checked, then trusted."""

from navigation.config.errors import ConfigError
from navigation.config.limits import limits_of
from navigation.config.load import load_config, parse_config
from navigation.config.sections import Config

__all__ = ["Config", "ConfigError", "limits_of", "load_config", "parse_config"]
