"""What running many scans costs: parallel efficiency, overhead of a task, and runs that are killed.

python -m benchmarks.batch --rooms 40 --kills 10

A machine that does other things at the same time makes the efficiency look worse than it is: the CPU seconds
of the tasks are printed beside the wall clock, so that the loss can be told apart from the neighbours'. The
overhead is that of tasks which are refused at once.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MANIFEST = """
[[simulate]]
name = "even"
walls = 8
rooms = {half}
seed = {seed}
points = {points}

[[simulate]]
name = "kinect"
sensor = "kinect_v1"
walls = 6
rooms = {half}
seed = {seed}
frames = 40
"""

MANY = 400
TINY = '[[simulate]]\nname = "s"\nplan = "box"\nrooms = {rooms}\npoints = 50\n'

TABLES = ("scans.csv", "lengths.csv", "summary.csv", "pairs.csv", "report.html")


def start(manifest: Path, out: Path, workers: int) -> subprocess.Popen:
    """Begin a run in a process of its own."""
    command = [sys.executable, "-m", "indoorfit", "evaluate", str(manifest), "--out", str(out)]
    return subprocess.Popen([*command, "--workers", str(workers), "--quiet"], stderr=subprocess.DEVNULL)


def timed(manifest: Path, out: Path, workers: int) -> tuple[float, float, float]:
    """Wall-clock seconds of a whole run; the sum of its tasks' wall and CPU seconds."""
    begin = time.perf_counter()
    code = start(manifest, out, workers).wait()
    wall_s = time.perf_counter() - begin
    assert code in (0, 3), f"exit code {code}"
    timings = [json.loads(path.read_text(encoding="utf-8")) for path in (out / "timings").iterdir()]
    return wall_s, sum(t["wall_s"] for t in timings), sum(t["cpu_s"] for t in timings)


def content(out: Path) -> dict[str, bytes]:
    """Everything that must be the same."""
    return {name: (out / name).read_bytes() for name in TABLES}


def killed_run(manifest: Path, out: Path, kills: int, longest_s: float, rng: random.Random) -> list[int]:
    """Start, kill at a random moment, again; then let it end. Rows that were there after each kill."""
    there = []
    for _ in range(kills):
        running = start(manifest, out, 2)
        try:
            running.wait(rng.uniform(0.0, longest_s))
        except subprocess.TimeoutExpired:
            running.send_signal(signal.SIGKILL)
            running.wait()
        there.append(len(list((out / "rows").glob("*.json"))) if (out / "rows").is_dir() else 0)
    assert start(manifest, out, 2).wait() in (0, 3)
    return there


def main() -> int:
    """Run, print, and judge against the figures that are promised."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rooms", type=int, default=40)
    parser.add_argument("--seed", type=int, default=30_000)
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--kills", type=int, default=10)
    wanted = parser.parse_args()
    rng = random.Random(wanted.seed)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        manifest = place / "study.toml"
        text = MANIFEST.format(half=wanted.rooms // 2, seed=wanted.seed, points=wanted.points)
        manifest.write_text(text, encoding="utf-8")
        # Once over, so that every run finds the compiled functions in the cache.
        timed(manifest, place / "warm", 2)
        one_s, one_tasks_s, one_cpu_s = timed(manifest, place / "one", 1)
        two_s, two_tasks_s, two_cpu_s = timed(manifest, place / "two", 2)
        load = os.getloadavg()[0]
        print(f"{wanted.rooms} rooms from seed {wanted.seed}; {os.cpu_count()} cores, load {load:.1f}")
        print(f"one worker   {one_s:7.1f} s; tasks {one_tasks_s:.1f} s, CPU {one_cpu_s:.1f} s")
        print(f"two workers  {two_s:7.1f} s; tasks {two_tasks_s:.1f} s, CPU {two_cpu_s:.1f} s")
        overhead_ms = 1e3 * overhead_s(place)
        efficiency = one_s / (2.0 * two_s)
        print(f"parallel efficiency {100 * efficiency:.0f} % (promised: 85)")
        print(f"overhead of a task  {overhead_ms:.0f} ms (promised: below 50)")
        same = content(place / "one") == content(place / "two")
        print(f"one and two workers write the same bytes: {same}")
        # Start-up takes some seconds, and so do the rooms that are left: kills fall into both.
        longest_s = 1.2 * two_s / max(wanted.kills, 1) + 4.0
        there = killed_run(manifest, place / "killed", wanted.kills, longest_s, rng)
        survived = content(place / "killed") == content(place / "one")
        print(f"rows after each kill: {there}; same tables in the end: {survived}")
        return 0 if same and survived and overhead_ms < 50.0 else 1


def overhead_s(place: Path) -> float:
    """What one more task costs beyond its own time, from tasks that are refused after some milliseconds."""
    beyond_s = []
    for rooms in (1, MANY):
        manifest = place / f"tiny-{rooms}.toml"
        manifest.write_text(TINY.format(rooms=rooms), encoding="utf-8")
        wall_s, tasks_s, _ = timed(manifest, place / f"tiny-{rooms}", 1)
        beyond_s.append(wall_s - tasks_s)
    return (beyond_s[1] - beyond_s[0]) / (MANY - 1)


if __name__ == "__main__":
    raise SystemExit(main())
