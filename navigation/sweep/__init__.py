"""Many variations of one simulated run, and their results.

- ``variations.py`` draws each run's starts, wheel and camera errors from the sweep's seed, and
  makes the run's configuration.
- ``workers.py`` opens the local processes or the Dask cluster.
- ``runs.py`` hands the variations out, repeats those of dead workers, and yields a row for each
  robot of each run.
- ``table.py`` writes the rows to a CSV or Parquet file and summarises them.
"""
