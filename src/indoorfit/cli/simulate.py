"""``indoorfit simulate``: a room whose truth is known, as a scan."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from indoorfit.errors import ConfigError, OutputError
from indoorfit.files import staged

from .maybe import Flag
from .runtime import set_up_logging
from .simulate_options import Contents, Plan, Sampling, Scanning, Way, refuse_unused

_RGBD_MARKS = ("intrinsics.txt", "groundtruth.txt")


@dataclass(frozen=True)
class SimulateCommand:
    """Write a simulated scan (PLY) of a room and its exact model beside it (SCAN.truth.json).

    A plan (box to stair) gets points drawn evenly from all surfaces, or with --sensor is scanned as a real
    room is: from a path or from stations, with what stands in the way, noise and drift. `random` makes up a
    furnished room or several; `scene` scans one from a file.
    """

    kind: tyro.conf.Positional[Literal["box", "L", "U", "X", "T", "Z", "stair", "random", "scene"]]
    """Plan of the room, or `random`, or `scene` (with --scene FILE)."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The PLY file to write."""
    tilt: float = 0.0
    """Tilt of the room's vertical, degrees."""
    yaw: float = 0.0
    """Turn about the vertical, degrees."""
    seed: int = 0
    """Same seed, same bytes."""
    overwrite: Flag = False
    """Replace existing files."""
    plan: tyro.conf.OmitArgPrefixes[Plan] = field(default_factory=Plan)
    sampling: tyro.conf.OmitArgPrefixes[Sampling] = field(default_factory=Sampling)
    contents: tyro.conf.OmitArgPrefixes[Contents] = field(default_factory=Contents)
    scanning: tyro.conf.OmitArgPrefixes[Scanning] = field(default_factory=Scanning)

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=False, verbose=False)
        way = self._way()
        refuse_unused(way, self.kind, (self.plan, self.sampling, self.contents, self.scanning))
        if self.seed < 0:
            raise ConfigError(f"simulate: seed {self.seed}. Fix: choose 0 or more.")
        targets, stale = self._targets()
        with staged(
            list(targets.values()), overwrite=self.overwrite, marks=_RGBD_MARKS, stale=stale
        ) as places:
            self._write(way, dict(zip(targets, places, strict=True)))
        return 0

    def _way(self) -> Way:
        if self.kind == "random" or self.kind == "scene":
            return self.kind
        return "sampled" if self.scanning.sensor is None else "scanned"

    def _targets(self) -> tuple[dict[str, Path], list[Path]]:
        """What is written where, and what must not stay beside it."""
        if self.output.suffix.lower() != ".ply":
            raise OutputError(
                f"{self.output}: the suffix is {self.output.suffix!r}; scans are written as PLY. "
                "Fix: name it .ply."
            )
        scanning = self.scanning
        targets = {"scan": self.output, "truth": self.output.with_suffix(".truth.json")}
        # Poses of an earlier scan would be read as those of the new one.
        poses = self.output.with_suffix(".frames.json")
        if scanning.sensor_poses:
            targets["poses"] = poses
        if scanning.write_scene is not None:
            if scanning.write_scene.suffix not in (".toml", ".json"):
                raise OutputError(f"{scanning.write_scene}: need .toml or .json. Fix: rename it.")
            targets["scene"] = scanning.write_scene
        if scanning.rgbd is not None:
            targets["rgbd"] = scanning.rgbd
        return targets, [] if scanning.sensor_poses else [poses]

    def _write(self, way: Way, places: dict[str, Path]) -> None:
        import numpy as np

        from indoorfit.io import write_frames_json, write_model_json, write_ply
        from indoorfit.pipeline import truth_result
        from indoorfit.simulate import write_scene

        from .simulate_room import sample_room
        from .simulate_scan import make_scene, scan_scene

        angles_deg = (self.tilt, self.yaw)
        if way == "sampled":
            rng = np.random.default_rng(self.seed)
            virtual, record = sample_room(
                self.kind, self.plan, self.sampling, self.contents, angles_deg, rng, self.output.name
            )
        else:
            # Apart from each other, so that a scene from a file is scanned as the random one was.
            scene_rng, scan_rng = (
                np.random.default_rng(seed) for seed in np.random.SeedSequence(self.seed).spawn(2)
            )
            scene = make_scene(way, self.kind, self.plan, self.contents, scene_rng)
            virtual, record = scan_scene(scene, self.scanning, angles_deg, scan_rng, places.get("rgbd"))
            if "scene" in places:
                write_scene(scene, places["scene"])
        truth = truth_result(virtual.shape, virtual.frame, record, self.seed, virtual)
        write_model_json(places["truth"], truth)
        if "poses" in places:
            write_frames_json(places["poses"], virtual.scan.frames)
        write_ply(places["scan"], virtual.scan)
