"""The same as the command line, in a few lines of Python."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from numpy.typing import ArrayLike

from indoorfit.config import RunConfig, config_from_dict
from indoorfit.errors import ConfigError
from indoorfit.files import FormatName
from indoorfit.io import PointCloud, Unit, as_scan, read_scan, read_tape
from indoorfit.measure import at_level
from indoorfit.model import (
    Dimension,
    Face,
    FitResult,
    Interval,
    Note,
    Pictures,
    Room,
    Scan,
    TapeTable,
    frozen,
)
from indoorfit.pipeline import fit_scan, held_again, with_tape, write_figures, write_outputs
from indoorfit.report import FigureFormat, dimension_table, notebook_html


@dataclass(frozen=True)
class RoomModel:
    """A fitted scan: what was found, and the scan that it was found in."""

    result: FitResult
    """Everything, in the terms of the output contract."""
    scan: Scan

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """All lengths with their intervals, metres."""
        return self.result.dimensions

    @property
    def rooms(self) -> tuple[Room, ...]:
        """Rooms with floor area, volume and perimeter."""
        return self.result.rooms

    @property
    def faces(self) -> tuple[Face, ...]:
        """Walls, floors and ceilings as polygons in the scan's coordinates."""
        return self.result.faces

    @property
    def warnings(self) -> tuple[Note, ...]:
        """What a reader of the numbers must know."""
        return self.result.notes

    def at_level(self, level: float) -> "RoomModel":
        """The same model with all intervals at another level of confidence; nothing is fitted again.

        Args:
            level: nominal coverage, between 0 and 1.

        Raises:
            ConfigError: the level is not between 0 and 1.
        """
        return replace(self, result=held_again(at_level(self.result, level)))

    def interval(self, name: str, level: float) -> Interval:
        """The interval of one quantity at any level.

        Args:
            name: the id of a dimension (``"A"``), or a room's quantity: ``"room-1.floor_area"``,
                ``"room-1.perimeter"`` or ``"room-1.volume"``.
            level: nominal coverage, between 0 and 1.

        Raises:
            ConfigError: there is no such quantity, or the level is not between 0 and 1.
        """
        result = at_level(self.result, level)
        known = {d.id: d.quantity for d in result.dimensions}
        for room in result.rooms:
            known[f"{room.id}.floor_area"] = room.floor_area
            known[f"{room.id}.perimeter"] = room.perimeter
            known[f"{room.id}.volume"] = room.volume
        if name not in known:
            raise ConfigError(f"interval: got {name!r}. Fix: choose one of {', '.join(known)}.")
        return known[name].interval

    def check(self, tape: str | Path | TapeTable) -> "RoomModel":
        """The same model compared with readings of a tape or laser meter: see `result.tape`.

        Args:
            tape: a CSV or TOML file, or what `indoorfit.io.read_tape` returns.

        Raises:
            InputError: the file cannot be read; rows that are wrong are in `result.tape.refused` instead.
        """
        table = tape if isinstance(tape, TapeTable) else read_tape(tape)
        return replace(self, result=with_tape(self.result, table))

    def write(
        self,
        directory: str | Path,
        *,
        overwrite: bool = False,
        formats: Sequence[FormatName] = (),
        pdf: bool = False,
    ) -> None:
        """Write all output files into a directory, whole or not at all.

        Args:
            directory: created; its parents too.
            overwrite: replace an earlier result in the same place.
            formats: further files, e.g. ``("ifc", "dxf")``.
            pdf: write the report as report.pdf, too.

        Raises:
            OutputError: the directory exists without `overwrite`, or cannot be written.
        """
        write_outputs(self.result, directory, self.scan, overwrite=overwrite, formats=formats, pdf=pdf)

    def write_figures(
        self, directory: str | Path, *, formats: Sequence[FigureFormat] = ("svg",), overwrite: bool = False
    ) -> tuple[str, ...]:
        """Write plan, residual histogram, normal vectors and the steps of the grammar as files for papers.

        Args:
            directory: created; ``figures.json`` in it has a caption for each figure.
            formats: ``svg``, ``pdf``, ``png``.
            overwrite: replace earlier figures in the same place.

        Returns:
            the names of the figures.

        Raises:
            ConfigError: an unknown format.
            OutputError: Matplotlib is not installed (``pip install 'indoorfit[figures]'``), or the directory
                exists without `overwrite`, or cannot be written.
        """
        config = config_from_dict(dict(self.result.provenance["config"]))
        return write_figures(self.result, self.scan, config, directory, formats=formats, overwrite=overwrite)

    def __repr__(self) -> str:
        return dimension_table(self.result)

    def _repr_html_(self) -> str:
        """The plan, the lengths and the warnings, for notebooks."""
        return notebook_html(self.result, self.scan.points_m)


def fit(
    scan: Scan | ArrayLike | PointCloud, config: RunConfig | None = None, pictures: Pictures | None = None
) -> RoomModel:
    """Turn a scan into a watertight model whose dimensions carry intervals.

    Args:
        scan: from `indoorfit.read`; an array (n, 3) of metres; or a point cloud of another library in metres,
            with points and colours as Open3D and trimesh have them.
        config: settings; see `RunConfig`.
        pictures: camera images and photos to put on the faces; see `indoorfit.io.read_posed_images`.

    Raises:
        InputError: the cloud cannot be a room; the message says why and what to do.
    """
    scan = as_scan(scan)
    return RoomModel(frozen(fit_scan(scan, config, pictures or Pictures())), scan)


def read(path: str | Path, *, unit: Unit = "m") -> Scan:
    """Read a point cloud: PLY, PCD, plain text (xyz, txt, csv, pts, asc), NPY or NPZ.

    Args:
        path: the file; the extension tells the format, the first bytes do where it is unknown.
        unit: unit of the file's coordinates, which are converted to metres.

    Raises:
        InputError: the file cannot be read as a cloud; the message says why.
        ConfigError: unknown unit.
    """
    return read_scan(path, unit=unit)
