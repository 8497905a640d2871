"""What holds for every test: strict numerics, no network, a cache of its own, repeatable examples."""

import os
import shutil
import socket
import tempfile
from dataclasses import dataclass

# Before JAX and NumPy are loaded. The numerics set the same defaults for the command line.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ["JAX_PLATFORMS"] = "cpu"
# One cache for all workers (they inherit it) and never the user's own.
_OWN_CACHE = None
if "INDOORFIT_TEST_CACHE" not in os.environ:
    _OWN_CACHE = tempfile.mkdtemp(prefix="indoorfit-tests-")
    os.environ["INDOORFIT_TEST_CACHE"] = _OWN_CACHE
os.environ["JAX_COMPILATION_CACHE_DIR"] = os.environ["INDOORFIT_TEST_CACHE"]
os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
os.environ["JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES"] = "-1"

import jax  # noqa: E402
import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

# x64 is not switched on here: the code does that itself where it needs it, and tests must see if it does not.
jax.config.update("jax_numpy_rank_promotion", "raise")

# The first example compiles, so no deadline; the same examples every time, so that a red run can be repeated.
settings.register_profile("indoorfit", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("indoorfit")


def pytest_unconfigure() -> None:
    """Remove the cache where this process made it."""
    if _OWN_CACHE is not None:
        shutil.rmtree(_OWN_CACHE, ignore_errors=True)


@pytest.fixture(autouse=True)
def _no_network(monkeypatch):
    """Nothing here may talk to another machine."""
    connect = socket.socket.connect

    def guarded(self, address):
        if self.family in (socket.AF_INET, socket.AF_INET6):
            raise AssertionError(f"a test wants to connect to {address}")
        return connect(self, address)

    monkeypatch.setattr(socket.socket, "connect", guarded)


@dataclass(frozen=True)
class Outcome:
    """What a command left: exit code, standard output and standard error."""

    code: int
    out: str
    err: str


@pytest.fixture
def run_cli(monkeypatch, capsys):
    """Run the command line in this process; arguments are turned into text."""
    from indoorfit.cli.main import main

    def run(*arguments) -> Outcome:
        monkeypatch.setattr("sys.argv", ["indoorfit", *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            main()
        captured = capsys.readouterr()
        code = caught.value.code
        return Outcome(0 if code is None else int(code), captured.out, captured.err)

    return run
