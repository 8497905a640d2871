"""Coverage and width of the intervals on simulated rooms at cell level.

    python benchmarks/uncertainty_cells.py --rooms 200 --first-seed 1000 --regimes p0 p5 p20 p50 --workers 2

Labels are the true ones and no ray is cast: this judges the noise models alone, not the front end. Prints a
table per regime and method: coverage at 50/80/95 %, mean and median width, interval score, RMSE, CPU seconds.
"""

import argparse
import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

# One thread per worker: the blocks are small, and a pool of BLAS threads would only wait for itself.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "fitting" / "uncertainty"))

import numpy as np
from cell_rooms import REGIMES, CellRoom, simulate_cell_room

from indoorfit.fitting.uncertainty import (
    FusionConfig,
    PoseFieldConfig,
    WallFieldConfig,
    cluster_robust,
    fuse,
    independent_points,
    point_noise_floor,
    pose_field_predictive,
    pose_obstacle,
    wall_field_predictive,
)

LEVELS = (0.5, 0.8, 0.95)


@dataclass(frozen=True)
class Score:
    """One dimension, one method."""

    room: int
    method: str
    kind: str
    error_mm: float
    width_mm: float
    floor_mm: float
    hits: tuple[bool, ...]
    score_mm: float
    cpu_s: float


def score_room(task: tuple[int, str]) -> list[Score]:
    """All methods on one room."""
    seed, name = task
    room = simulate_cell_room(seed, REGIMES[name])
    floor = np.diff(point_noise_floor(room.cells, room.contrasts).interval(0.95), axis=0)[0]
    scores: list[Score] = []

    def add(method: str, answer, started: float) -> None:
        spent = time.process_time() - started
        ends = [answer.interval(level) for level in LEVELS]
        low, high = ends[-1]
        truth = room.truth_m
        loss = high - low + 40 * np.maximum(low - truth, 0) + 40 * np.maximum(truth - high, 0)
        for k, kind in enumerate(room.kinds):
            hits = tuple(bool(a[k] <= truth[k] <= b[k]) for a, b in ends)
            error = float(answer.mean[k] - truth[k])
            width = float(high[k] - low[k])
            scores.append(
                Score(
                    seed, method, kind, 1e3 * error, 1e3 * width, 1e3 * floor[k], hits, 1e3 * loss[k], spent
                )
            )

    started = time.process_time()
    add("iid", independent_points(room.cells, room.contrasts), started)
    started = time.process_time()
    wall = wall_field_predictive(room.cells, room.contrasts, WallFieldConfig(), np.random.default_rng(seed))
    add("wall", wall, started)
    add("blocks16", _blocks(room), time.process_time())
    if pose_obstacle(room.frame_cells, PoseFieldConfig()) is None:
        started = time.process_time()
        rng = np.random.default_rng(seed)
        pose, _ = pose_field_predictive(room.frame_cells, room.contrasts, PoseFieldConfig(), rng)
        add("pose", pose, started)
        started = time.process_time()
        add("fusion", fuse(wall, pose, FusionConfig(inconsistent_sigmas=np.inf)), started)
        add("fusion+flag", fuse(wall, pose, FusionConfig()), started)
    return scores


def _blocks(room: CellRoom):
    """CR2 on 16 contiguous blocks of frames."""
    cells = room.frame_cells
    assert cells.frames is not None
    blocks = cells.frames * 16 // (int(cells.frames.max()) + 1)
    return cluster_robust(cells, room.contrasts, blocks, np.sqrt(cells.counts))


def summarise(scores: list[Score]) -> str:
    """One line of figures."""
    hits = 100 * np.mean([s.hits for s in scores], axis=0)
    width = np.array([s.width_mm for s in scores])
    error = np.array([s.error_mm for s in scores])
    by_room: dict[int, list[bool]] = {}
    for s in scores:
        by_room.setdefault(s.room, []).append(s.hits[-1])
    rooms = list(by_room.values())
    rng = np.random.default_rng(0)
    picks = rng.integers(0, len(rooms), (400, len(rooms)))
    resampled = [np.mean(np.concatenate([rooms[i] for i in pick])) for pick in picks]
    ratio = np.median(width / [s.floor_mm for s in scores])
    cpu = np.mean([s.cpu_s for s in scores])
    return (
        f"{hits[0]:4.0f}/{hits[1]:3.0f}/{hits[2]:5.1f}+-{100 * np.std(resampled):3.1f} "
        f"w {width.mean():7.2f} ({np.median(width):6.2f}, max {width.max():7.1f}, x floor {ratio:5.1f}) "
        f"IS {np.mean([s.score_mm for s in scores]):7.2f} R {np.sqrt(np.mean(error**2)):6.2f} "
        f"median {np.median(np.abs(error)):5.2f} cpu {cpu:.3f} n {len(scores)}"
    )


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rooms", type=int, default=200)
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--regimes", nargs="+", default=list(REGIMES))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", type=Path, help="write every score here")
    args = parser.parse_args()
    everything: dict[str, list[Score]] = {}
    with ProcessPoolExecutor(args.workers) as pool:
        for name in args.regimes:
            tasks = [(args.first_seed + k, name) for k in range(args.rooms)]
            scores = [s for room in pool.map(score_room, tasks, chunksize=4) for s in room]
            everything[name] = scores
            for method in dict.fromkeys(s.method for s in scores):
                own = [s for s in scores if s.method == method]
                print(f"{name:8s} {method:12s} {summarise(own)}", flush=True)
    pooled = [s for name, scores in everything.items() if name != "D" for s in scores]
    for method in dict.fromkeys(s.method for s in pooled):
        print(f"{'pooled':8s} {method:12s} {summarise([s for s in pooled if s.method == method])}")
    if args.json:
        args.json.write_text(json.dumps({k: [vars(s) for s in v] for k, v in everything.items()}))


if __name__ == "__main__":
    main()
