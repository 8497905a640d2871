"""``indoorfit convert``: a model in other formats."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from indoorfit.errors import ConfigError
from indoorfit.files import FormatName, staged

from .maybe import Flag, Maybe
from .runtime import set_up_logging

if TYPE_CHECKING:
    from indoorfit.model import FitResult


@dataclass(frozen=True)
class ConvertCommand:
    """Write a model.json as GLB, VRML, X3D, OBJ, PLY, STL, 3MF, Collada, IFC4, CityJSON or a plan to scale.

    The suffix decides: .glb .wrl .x3d .obj .ply .stl .3mf .dae .ifc .city.json for models, .dxf .pdf .svg
    .png for plans, .csv for the dimensions. Several files appear together or not at all.
    """

    model: tyro.conf.Positional[Path]
    """model.json of an earlier fit (or SCAN.truth.json of a simulation)."""
    output: Annotated[tyro.conf.UseAppendAction[tuple[Path, ...]], tyro.conf.arg(aliases=["-o"])]
    """File to write; give it again for further files."""
    format: Maybe[FormatName] = None
    """Format, where the suffix shall not decide."""
    scale: Maybe[int] = None
    """N of the plans' scale 1:N; default: the first of 1:50, 1:100, 1:200, ... that fits A4 or A3."""
    overwrite: Flag = False
    """Replace existing files."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=False, verbose=False)
        if not self.output:
            raise ConfigError("convert: nothing to write. Fix: name a file, e.g. -o room.ifc.")
        if self.scale is not None and self.scale < 1:
            raise ConfigError(f"convert: scale 1:{self.scale}. Fix: give a whole number, e.g. --scale 50.")
        from indoorfit.pipeline import format_of

        formats = [format_of(path, self.format) for path in self.output]
        if self.scale is not None and not any(kind.is_plan for kind in formats):
            raise ConfigError("convert: --scale is for plans (dxf, pdf, svg, png). Fix: leave it out.")
        result = self._model()
        with staged(self.output, overwrite=self.overwrite) as places:
            for place, kind in zip(places, formats, strict=True):
                kind.write(place, result, self.scale)
        return 0 if result.converged else 3

    def _model(self) -> "FitResult":
        from indoorfit.io import read_model_json
        from indoorfit.pipeline import with_meshes

        return with_meshes(read_model_json(self.model), self.model.name)
