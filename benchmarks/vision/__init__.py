"""Global Vision beside OpenCV, with truth: ``python -m benchmarks.vision``."""
