"""The traced solver, kept between runs beside JAX's own compilation cache.

JAX's cache saves compiling but not tracing, and tracing needs optimistix and equinox loaded: together
that is half of the start-up time. So the traced programme is kept as well, where, and only where, the
user has given JAX a cache directory.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

import jax
import jax.export
import jax.numpy as jnp

from .plane_residuals import Problem, Unknowns

_SAME_VERSION = [jax.export.DisabledSafetyCheck.custom_call("lapack_dormqr_ffi")]
"""JAX promises this LAPACK call for one version only; the file's name holds the version."""


_DIGEST_BYTES = 32


@lru_cache
def compiled_solver(n_planes: int) -> Callable:
    """`optimise.minimise` for a fixed number of planes, ready to call with x64 enabled."""
    path = _path(n_planes)
    stored = None if path is None else _load(path)
    if stored is not None:
        # Lowering any factorisation makes JAX load LAPACK, which a stored programme does not do.
        jax.jit(jnp.linalg.qr).lower(jnp.eye(2))
        exported = jax.export.deserialize(bytearray(stored))
    else:
        from .optimise import minimise

        exported = jax.export.export(jax.jit(_flat(minimise)), disabled_checks=_SAME_VERSION)(
            *_signature(n_planes)
        )
        if path is not None:
            _store(path, bytes(exported.serialize()))
    call = jax.jit(exported.call)
    return lambda start, problem: call(*start, *problem)


def _flat(minimise: Callable) -> Callable:
    """Plain arrays in and out: exported programmes know no named tuples."""
    return lambda *arrays: minimise(Unknowns(*arrays[:2]), Problem(*arrays[2:]))


def _signature(n: int) -> list[jax.ShapeDtypeStruct]:
    shapes = [(3,), (n,), (n, 3), (n,), (n, 3), (n, 3, 3), (n,), (n,)]
    return [jax.ShapeDtypeStruct(shape, jnp.float64) for shape in shapes]


def _path(n_planes: int) -> Path | None:
    directory = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    if not directory:
        return None
    versions = "-".join(version(name) for name in ("indoorfit", "jax", "optimistix"))
    name = f"indoorfit-solver-{versions}-{_source_digest()}-{jax.default_backend()}-{n_planes}"
    return Path(directory) / name


def _source_digest() -> str:
    """Changes whenever the traced code does, so that a stale programme is never used."""
    folder = Path(__file__).parent
    source = b"".join((folder / name).read_bytes() for name in ("plane_residuals.py", "optimise.py"))
    return hashlib.sha256(source).hexdigest()[:12]


def _load(path: Path) -> bytes | None:
    """The stored programme, or None where there is none that is as it was written."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, programme = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    return programme if hashlib.sha256(programme).digest() == digest else None


def _store(path: Path, programme: bytes) -> None:
    """Whole or not at all; a cache that cannot be written is no reason to fail."""
    content = hashlib.sha256(programme).digest() + programme
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(content)
        os.replace(file.name, path)
    except OSError:
        return
