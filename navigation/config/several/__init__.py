"""Several robots in one configuration: each as a configuration of its own, and what must fit."""
