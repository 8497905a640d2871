"""What the program reaches on simulated rooms, and whether a change makes it worse: ``python -m benchmarks``."""
