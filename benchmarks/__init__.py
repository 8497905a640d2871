"""What the program reaches on simulated rooms: ``python -m benchmarks``."""
