"""When an assumption of the intervals counts as broken."""

from dataclasses import dataclass


@dataclass(frozen=True)
class HonestyConfig:
    """Thresholds of the warnings about the intervals' own assumptions."""

    tilt_sigmas: float = 3.0
    """A face is tilted or bowed if it is so by more than this many standard uncertainties, and by more than
    the half width of its own position's interval: less than that is in the interval already."""
    misfit_ratio: float = 4.0
    """A face's patches scatter this many times as much (in variance) as the noise model says: its intervals
    are then too narrow by half."""
    misfit_chance: float = 1e-4
    """And by chance they would do so in fewer than this share of faces."""
    min_coverage: float = 0.4
    """Share of a face's area with points below which what was measured may be what stands before it."""
    max_screened: float = 0.2
    """Share of a face's patches that contradict the others, from which on too much of it is not wall."""
    frame_blocks: int = 16
    """The frames are cut into this many contiguous blocks; with fewer frames each is a block."""
    min_blocks: int = 3
    """Least blocks that must have seen a face."""
    max_block_share: float = 0.8
    """Largest share of a face's points that one block may have."""
    layer_valley: float = 0.5
    """Two layers are told apart where the points between them are less dense than this share of the thinner
    layer: layers of normal noise are, when they are 3.4 standard deviations apart."""
    layer_share: float = 0.15
    """Least share of the points that the thinner layer must have."""
    layer_mixed: float = 0.5
    """Share of the squares of 10 cm in which both layers must occur: beside each other they are furniture."""
    max_points: int = 100_000
    """At most this many points are looked at, every k-th: shares of them need no more."""
