"""The stored solver is the solver: same numbers, and never in the way."""

import jax
import numpy as np
import pytest

from indoorfit.fitting import solver_cache
from indoorfit.fitting.least_squares import solve
from indoorfit.fitting.moments import plane_moments


@pytest.fixture
def cache_at(monkeypatch):
    """Point the cache somewhere and forget what this process has compiled."""

    def point(directory) -> None:
        solver_cache.compiled_solver.cache_clear()
        monkeypatch.setattr(
            solver_cache, "_path", lambda n: None if directory is None else directory / f"solver-{n}"
        )

    yield point
    solver_cache.compiled_solver.cache_clear()


def solution():
    rng = np.random.default_rng(0)
    plane = np.repeat(np.arange(6), 50)
    points_m = rng.uniform(-2, 2, (300, 3))
    points_m[np.arange(300), plane % 3] = plane - 2.5 + rng.normal(0, 0.01, 300)
    moments = plane_moments(points_m, plane, np.full(300, 1e4), 6)
    return solve(moments, np.eye(3)[np.arange(6) % 3], np.arange(6) - 2.45)


def test_a_stored_solver_gives_the_same_bytes_as_a_fresh_one(cache_at, tmp_path):
    cache_at(None)
    fresh = solution()
    cache_at(tmp_path)
    storing = solution()
    assert [path.name for path in tmp_path.iterdir()] == ["solver-32"], "whole, and nothing beside it"
    cache_at(tmp_path)
    stored = solution()
    for found in (storing, stored):
        np.testing.assert_array_equal(found.offsets_m, fresh.offsets_m)
        np.testing.assert_array_equal(found.rotation_rad, fresh.rotation_rad)
        assert found.cost == fresh.cost


def test_a_cache_that_cannot_be_written_is_no_reason_to_fail(cache_at, tmp_path):
    blocker = tmp_path / "file"
    blocker.write_bytes(b"")
    cache_at(blocker / "below")
    assert solution().converged


@pytest.mark.parametrize("content", [b"", b"\0" * 100, b"half a programme"], ids=["empty", "zeros", "text"])
def test_a_damaged_entry_is_replaced(cache_at, tmp_path, content):
    """A disk that was full, or a copy that was cut off, must not end every later run."""
    (tmp_path / "solver-32").write_bytes(content)
    cache_at(tmp_path)
    assert solution().converged


def test_name_of_the_entry_changes_with_the_code_and_the_versions(monkeypatch):
    jax_dir = jax.config.jax_compilation_cache_dir
    try:
        jax.config.update("jax_compilation_cache_dir", "somewhere")
        first = solver_cache._path(32)
        assert first is not None
        assert first != solver_cache._path(64)
        monkeypatch.setattr(solver_cache, "version", lambda name: "0.0.0")
        assert solver_cache._path(32) != first
        monkeypatch.setattr(solver_cache, "_source_digest", lambda: "other")
        second = solver_cache._path(32)
        assert second is not None
        assert "other" in second.name
        jax.config.update("jax_compilation_cache_dir", None)
        assert solver_cache._path(32) is None, "only where the user has given a cache directory"
    finally:
        jax.config.update("jax_compilation_cache_dir", jax_dir)
