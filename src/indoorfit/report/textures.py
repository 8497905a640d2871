"""What the report says of the images on the faces."""

from indoorfit.model import FitResult

_SOURCES = {"points": "points of the scan", "images": "camera images", "photo": "a photo"}


def texture_rows(result: FitResult) -> list[tuple[str, str, str, str, str, str]]:
    """Face, file, source, pixel in cm, seen and filled in per cent; empty without textures."""
    if result.textures is None:
        return []
    return [
        (
            placement.face,
            placement.image,
            _SOURCES[placement.source],
            f"{100.0 * placement.pixel_m:.2g}",
            _per_cent(placement.seen),
            _per_cent(placement.filled),
        )
        for placement in result.textures.placements.values()
    ]


def _per_cent(share: float) -> str:
    """Only all is 100 %, and only nothing is 0 %."""
    rounded = round(100.0 * share, 1)
    if rounded == 100.0 and share < 1.0:
        return "99.9"
    return "0.1" if rounded == 0.0 and share > 0.0 else f"{rounded:g}"
