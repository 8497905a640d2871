"""What a process needs before NumPy and JAX are loaded. Imports nothing of either."""

import os
from pathlib import Path

import platformdirs


def prepare_numerics() -> None:
    """Set up BLAS and XLA for many small problems. Must run before NumPy is imported.

    The largest matrix here has some hundred rows: more threads cost more in waking up than they save, and
    keep other scans of a batch from the cores.
    """
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
    # Only a CPU is needed; looking for others takes time and prints warnings.
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    cache = Path(platformdirs.user_cache_dir("indoorfit")) / "jax"
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(cache))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES", "-1")
