"""What it takes to start: compiling every kernel, and a fresh environment with the wheel."""
