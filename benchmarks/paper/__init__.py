"""The paper's figures and tables, made by this code from seeds: `python -m benchmarks.paper`."""
