"""The connected parts of a plane: each is a face of its own."""

from dataclasses import dataclass, replace

from scipy import ndimage

from .exposure import Exposure


@dataclass(frozen=True)
class SeenPiece:
    """What was seen of one connected part of a plane."""

    part: Exposure
    n_points: int
    coverage: float
    """Share of its area that points were seen on, 0 to 1."""


def pieces(exposure: Exposure) -> tuple[Exposure, ...]:
    """The visible part of a plane, taken apart where it is not connected; none where nothing is visible.

    Floors and ceilings with corners cut off count as one.
    """
    if exposure.corners:
        return (exposure,)
    labels, n = ndimage.label(exposure.mask)  # type: ignore[misc]
    return tuple(replace(exposure, mask=labels == k) for k in range(1, n + 1))
