"""Does a face hang on one stretch of the scan, whose error no residual shows?"""

import numpy as np

from indoorfit.model import Note

from .config import HonestyConfig
from .evidence import Evidence, FacePoints

_SEEN_SHARE = 0.01
"""A block has seen a face from which it has at least this share of the points."""


def block_notes(evidence: Evidence, points: FacePoints, config: HonestyConfig) -> tuple[Note, ...]:
    """SINGLE_BLOCK: faces that one contiguous block of frames has (nearly) alone seen.

    A single frame has no registration that could be wrong, so a scan of one frame is never reported. Without
    frame ids nothing can be said here; the noise model's explanation says so.
    """
    if points.frames is None or points.n_frames < 2:
        return ()
    n_blocks = min(config.frame_blocks, points.n_frames)
    parts, found = [], []
    for plane in evidence.judged:
        frames = points.frames[plane]
        if len(frames) == 0:
            continue
        share = np.bincount(frames * n_blocks // points.n_frames, minlength=n_blocks) / len(frames)
        n_seen = int(np.sum(share >= _SEEN_SHARE))
        # With few stations, as a laser scanner has, two of them are already independent witnesses.
        few = n_blocks == config.frame_blocks and n_seen < config.min_blocks
        if few or share.max() > config.max_block_share:
            found.append(plane)
            parts.append(
                f"{evidence.listed([plane])} ({n_seen} of {n_blocks} blocks, {100 * share.max():.0f} % of "
                "the points from one)"
            )
    if not parts:
        return ()
    blocks = "stations or frames" if n_blocks == points.n_frames else "contiguous blocks of frames"
    return (
        Note(
            "SINGLE_BLOCK",
            f"Seen by few {blocks}: {'; '.join(parts)}. If these were registered wrongly, the face is "
            "displaced as a whole, and no residual shows it. Pass it again from elsewhere, or measure by "
            "hand.",
            evidence.named(found),
        ),
    )
