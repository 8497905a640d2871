"""CPU time and memory of a whole run against a yardstick that every machine can repeat.

    python -m benchmarks.speed --points 1400000 --repeat 3

- `fit`: `indoorfit fit SCAN.ply --out DIR` in a process of its own, from the file to all outputs.
- `neighbours`: scipy's cKDTree built over the same points and asked for the 8 neighbours of each, one thread.
- `small`: the same command on 5000 points: what a start costs whatever the scan's size.

A first run that is not counted fills the compilation cache; then the best of the repeats counts. Linux and
macOS only: the figures come from the process accounts.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from benchmarks.tables import machine, table
from indoorfit.simulate import RoomKind

YARDSTICK = """
import sys, time
import numpy as np
from scipy.spatial import cKDTree
points = np.load(sys.argv[1])
start = time.process_time()
cKDTree(points).query(points, k=8, workers=1)
print(time.process_time() - start)
"""


@dataclass(frozen=True)
class Cost:
    """Of one process."""

    cpu_s: float
    wall_s: float
    peak_mb: float


def measured(command: list[str]) -> tuple[Cost, str]:
    """Run a command and read its account; also what it printed.

    Raises:
        SystemExit: the command failed.
    """
    start = time.perf_counter()
    with tempfile.TemporaryFile() as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL)
        # wait4 and not getrusage: the latter sums over all children so far.
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        wall_s = time.perf_counter() - start
        out.seek(0)
        text = out.read().decode()
    if process.returncode:
        raise SystemExit(f"{' '.join(command[:4])}: exit code {process.returncode}")
    # ru_maxrss: kilobytes on Linux, bytes on macOS.
    scale = 1e-6 if sys.platform == "darwin" else 1.024e-3
    return Cost(usage.ru_utime + usage.ru_stime, wall_s, usage.ru_maxrss * scale), text


def indoorfit(*arguments: str) -> list[str]:
    """The command line of this interpreter's indoorfit."""
    return [sys.executable, "-m", "indoorfit", *arguments]


def simulate(folder: Path, kind: RoomKind, points: int, seed: int) -> Path:
    """A scan as PLY; its points also as NPY for the yardstick."""
    import numpy as np

    from indoorfit.io import read_scan

    path = folder / f"scan-{points}.ply"
    measured(
        indoorfit(
            "simulate", kind, "-o", str(path), "--points", str(points), "--seed", str(seed),
            "--furniture", "2", "--windows", "1", "--yaw", "23", "--tilt", "3",
        )
    )  # fmt: skip
    np.save(path.with_suffix(".npy"), read_scan(path).points_m)
    return path


def best_fit(scan: Path, folder: Path, repeat: int) -> Cost:
    """The cheapest of several runs of the whole command."""
    command = indoorfit("fit", str(scan), "--out", str(folder / "out"), "--overwrite", "--quiet")
    measured(command)
    return min((measured(command)[0] for _ in range(repeat)), key=lambda cost: cost.cpu_s)


def best_yardstick(scan: Path, repeat: int) -> float:
    """CPU seconds of the neighbour queries, reading the file not counted."""
    command = [sys.executable, "-c", YARDSTICK, str(scan.with_suffix(".npy"))]
    return min(float(measured(command)[1]) for _ in range(repeat))


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--points", type=int, default=1_400_000)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", default="X", help="plan of the room")
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        large = simulate(folder, wanted.kind, wanted.points, wanted.seed)
        small = simulate(folder, wanted.kind, 5000, wanted.seed)
        whole = best_fit(large, folder, wanted.repeat)
        yardstick_s = best_yardstick(large, wanted.repeat)
        start = best_fit(small, folder, wanted.repeat)
    print(machine())
    print(f"{wanted.kind}, {wanted.points} points; best of {wanted.repeat}\n")
    print(
        table(
            ("what", "CPU s", "wall s", "peak MB"),
            [
                (
                    "fit, PLY to all outputs",
                    f"{whole.cpu_s:.2f}",
                    f"{whole.wall_s:.2f}",
                    f"{whole.peak_mb:.0f}",
                ),
                ("cKDTree and 8 neighbours", f"{yardstick_s:.2f}", "", ""),
                ("fit of 5000 points", f"{start.cpu_s:.2f}", f"{start.wall_s:.2f}", f"{start.peak_mb:.0f}"),
            ],
        )
    )
    print(f"\nfit / yardstick: {whole.cpu_s / yardstick_s:.2f}")


if __name__ == "__main__":
    main()
