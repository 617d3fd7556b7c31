"""A Python in which Clearway finds only what every system has; see `sitecustomize`."""
