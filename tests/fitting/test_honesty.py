"""Each warning about the intervals' assumptions fires where one is broken, and not where none is."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from indoorfit import RunConfig
from indoorfit.fitting import AssociationConfig, HonestyConfig, JointConfig
from indoorfit.model import FitResult, Scan
from indoorfit.pipeline import fit_scan
from indoorfit.simulate import VirtualScan
from synthetic import virtual

HONESTY = {
    "NOT_PARALLEL", "NOT_PLANAR", "SINGLE_BLOCK", "LAYERED", "OCCLUDED", "CONTAMINATED", "MISFIT",
    "PRIOR_DOMINATED",
}  # fmt: skip
AXIS, ALONG = 0, 1
"""What is done is done to the box's +x wall; it runs along y."""
N_FRAMES = 48


def box(seed: int = 0) -> VirtualScan:
    return virtual("box", seed, n_points=25_000)


def changed(seed, change, frame_ids=None) -> Scan:
    """A box whose wall's points were moved across the wall by `change(points_m, rng)`, Manhattan metres."""
    made, rng = box(seed), np.random.default_rng(seed)
    points_m = made.frame.to_manhattan(made.scan.points_m)
    own = on_wall(made)
    points_m[own, AXIS] += change(points_m[own], rng)
    ids = None if frame_ids is None else frame_ids(made, rng)
    # Without colours nothing is painted, which would take longer than the fit.
    return replace(made.scan, points_m=made.frame.to_scan(points_m), frame_ids=ids, colours=None)


@cache
def fitted(seed, change, frame_ids=None) -> FitResult:
    """The model of `changed`, with default settings; results are immutable, so that tests can share them."""
    return fit_scan(changed(seed, change, frame_ids))


def plane(made: VirtualScan, axis: int, outward: int) -> int:
    return next(k for k, p in enumerate(made.shape.planes) if (p.axis, p.outward) == (axis, outward))


def on_wall(made: VirtualScan) -> np.ndarray:
    return made.point_plane == plane(made, AXIS, 1)


def codes(result: FitResult) -> set[str]:
    return {note.code for note in result.notes} & HONESTY


def message(result: FitResult, code: str) -> str:
    return next(note.message for note in result.notes if note.code == code)


def wall_id(result: FitResult) -> str:
    """The face that the changes were made to."""
    return next(face.id for face in result.faces if face.face_class == "right")


def unchanged(points_m, rng):
    return np.zeros(len(points_m))


def mixed_frames(made, rng):
    return rng.integers(0, N_FRAMES, made.scan.n_points)


@pytest.mark.parametrize("frame_ids", [None, mixed_frames], ids=["bare", "with frames"])
def test_a_sound_scan_raises_no_alarm(frame_ids):
    for seed in range(4):
        assert codes(fitted(seed, unchanged, frame_ids)) == set()


def patchy(scatter_m, share=1.0):
    """Every square of 0.7 m (or a share of them) displaced on its own."""

    def change(points_m, rng):
        cells = np.floor(points_m[:, 1:] / 0.7).astype(int) + 100
        key = cells[:, 0] * 1000 + cells[:, 1]
        shifts = {
            int(k): scatter_m * rng.choice([-1.0, 1.0]) * (rng.random() < share) for k in np.unique(key)
        }
        return np.array([shifts[int(k)] for k in key])

    return change


def tilted(points_m, rng):
    return np.tan(np.radians(1.0)) * points_m[:, ALONG]


def bowed(points_m, rng):
    return -0.03 * (points_m[:, ALONG] / np.abs(points_m[:, ALONG]).max()) ** 2


def wavy(points_m, rng):
    """A wave of 4 m: neighbouring patches agree, so that few of them look like furniture."""
    return 0.008 * np.sin(2.0 * np.pi * points_m[:, ALONG] / 4.0)


def doubled(points_m, rng):
    return 0.06 * (rng.random(len(points_m)) < 0.5)


@pytest.mark.parametrize(
    ("code", "change", "said"),
    [
        ("NOT_PARALLEL", tilted, "°"),
        ("NOT_PLANAR", bowed, "mm between middle and ends"),
        ("LAYERED", doubled, "(60 mm apart"),
        ("MISFIT", wavy, "by a factor of"),
        ("CONTAMINATED", patchy(0.05, share=0.35), "patches"),
    ],
)
def test_a_spoilt_wall_is_named(code, change, said):
    result = fitted(3, change)
    assert code in codes(result)
    assert wall_id(result) in message(result, code)
    assert said in message(result, code)
    assert [note.faces for note in result.notes if note.code == code] == [(wall_id(result),)]
    # The rest of the room is as it should be.
    others = {face.id for face in result.faces} - {wall_id(result)}
    assert not any(name in message(result, code) for name in others)


@pytest.mark.parametrize("size", [0.1, 0.01], ids=["a tenth", "a hundredth"])
@pytest.mark.parametrize("change", [tilted, bowed], ids=["tilted", "bowed"])
def test_a_shape_within_the_interval_is_no_alarm(change, size):
    """A tenth of a millimetre over a wall whose place is known to a few tenths."""
    result = fit_scan(changed(3, lambda points_m, rng: 0.02 * size * change(points_m, rng)))
    assert codes(result) == set()


def test_layers_within_the_noise_are_no_alarm():
    """Two normal layers of 5 mm that are 10 mm apart have no valley between them."""
    result = fit_scan(changed(3, lambda points_m, rng: 0.01 * (rng.random(len(points_m)) < 0.5)))
    assert "LAYERED" not in codes(result)


def test_a_step_beside_the_wall_is_not_two_layers():
    """Half of the wall 6 cm back: two planes, but nowhere both at once."""
    result = fit_scan(changed(3, lambda points_m, rng: 0.06 * (points_m[:, ALONG] > 0.0)))
    assert "LAYERED" not in codes(result)


def one_block(made, rng):
    ids = mixed_frames(made, rng)
    own = on_wall(made)
    # Frames 12, 13, 14 are one of the 16 blocks of 48.
    ids[own] = rng.integers(12, 15, int(own.sum()))
    return ids


def two_stations(made, rng):
    return rng.integers(0, 2, made.scan.n_points)


def one_station(made, rng):
    return np.zeros(made.scan.n_points, int)


def wall_from_one_of_two(made, rng):
    ids = two_stations(made, rng)
    ids[on_wall(made)] = 1
    return ids


@pytest.mark.parametrize(("frame_ids", "fires"), [
    (one_block, True), (wall_from_one_of_two, True), (mixed_frames, False), (two_stations, False),
    (one_station, False), (None, False),
])  # fmt: skip
def test_a_wall_that_hangs_on_one_block_of_frames_is_named(frame_ids, fires):
    result = fitted(1, unchanged, frame_ids)
    assert ("SINGLE_BLOCK" in codes(result)) == fires
    if fires:
        assert wall_id(result) in message(result, "SINGLE_BLOCK")
        assert "100 % of the points from one" in message(result, "SINGLE_BLOCK")


def test_blocks_without_ids_are_told_once_in_the_explanation():
    bare, known = (fitted(1, unchanged, ids) for ids in (None, mixed_frames))
    assert "without frame ids" in bare.noise["explanation"]
    assert not any("frame ids" in note.message for note in bare.notes)
    assert known.noise["explanation"]


def with_hole(share: float) -> Scan:
    """A box whose wall shows in its topmost part only."""
    made = box(2)
    height_m = made.frame.to_manhattan(made.scan.points_m)[:, 2]
    low, high = (made.shape.planes[plane(made, 2, side)].offset_m for side in (-1, 1))
    kept = ~on_wall(made) | (height_m > high - share * (high - low))
    return replace(made.scan, points_m=made.scan.points_m[kept], colours=None)


@pytest.mark.parametrize(("share", "fires"), [(0.3, True), (0.8, False)])
def test_a_wall_seen_in_small_part_is_named(share, fires):
    result = fit_scan(with_hole(share))
    assert ("OCCLUDED" in codes(result)) == fires
    if fires:
        assert wall_id(result) in message(result, "OCCLUDED")


@pytest.mark.parametrize(("patch_m", "fires"), [(10.0, True), (0.7, False)])
def test_a_scan_that_teaches_nothing_leaves_the_prior(patch_m, fires):
    """One patch a face: how patches scatter about their plane cannot be seen."""
    joint = JointConfig(association=AssociationConfig(patch_m=patch_m))
    result = fit_scan(changed(0, unchanged), RunConfig(joint=joint))
    assert ("PRIOR_DOMINATED" in codes(result)) == fires


def test_thresholds_are_settings():
    strict = RunConfig(honesty=HonestyConfig(min_coverage=1.0))
    assert "OCCLUDED" in codes(fit_scan(with_hole(0.8), strict))
