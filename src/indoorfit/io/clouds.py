"""Point clouds of other libraries, told by what they have and not by where they come from."""

from dataclasses import replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..model import Scan
from .scan import scan_from_arrays


@runtime_checkable
class PointsCloud(Protocol):
    """As Open3D's `PointCloud`: points and colours, (n, 3) each, the colours 0.0 to 1.0 or empty."""

    @property
    def points(self) -> Any:
        """(n, 3) metres."""
        ...

    @property
    def colors(self) -> Any:
        """(n, 3) or (n, 4), or empty."""
        ...


@runtime_checkable
class VerticesCloud(Protocol):
    """As trimesh's `PointCloud`, which may have `colors`, too: 0 to 255 with alpha, or empty."""

    @property
    def vertices(self) -> Any:
        """(n, 3) metres."""
        ...


@runtime_checkable
class TensorCloud(Protocol):
    """As Open3D's tensor `PointCloud`: ``positions`` and maybe ``colors`` under `point`."""

    @property
    def point(self) -> Any:
        """Tensors by name."""
        ...


PointCloud = PointsCloud | VerticesCloud | TensorCloud
"""A cloud of another library."""


def as_scan(cloud: Scan | ArrayLike | PointCloud) -> Scan:
    """A `Scan` as it is, and from arrays and clouds of other libraries a checked copy.

    Args:
        cloud: metres.

    Raises:
        InputError: no points, wrong shapes or kinds, or too few points.
    """
    if isinstance(cloud, Scan):
        return cloud
    found = _parts(cloud)
    if found is None:
        return scan_from_arrays(cloud)  # pyright: ignore[reportArgumentType]
    points, colours = (None if part is None else np.asarray(part) for part in found)
    assert points is not None, "a cloud has points"
    # Libraries say "no colours" with none, or with an empty array.
    scan = scan_from_arrays(points, colours if colours is not None and colours.size else None)
    return replace(scan, name=type(cloud).__name__)


def _parts(cloud: Any) -> tuple[Any, Any] | None:
    """Points and colours; None for what is no cloud of a library."""
    if isinstance(cloud, np.ndarray | list | tuple):
        return None
    tensors = getattr(cloud, "point", None)
    if tensors is not None and "positions" in tensors:
        colours = tensors["colors"].numpy() if "colors" in tensors else None
        return tensors["positions"].numpy(), colours
    for name in ("points", "vertices"):
        points = getattr(cloud, name, None)
        if points is not None and not callable(points):
            return points, getattr(cloud, "colors", None)
    if not hasattr(cloud, "__array__"):
        raise InputError(
            f"fit: got {type(cloud).__name__}; a scan, an array (n, 3) or a cloud with `points` is needed. "
            "Fix: pass an array of the coordinates."
        )
    return None
