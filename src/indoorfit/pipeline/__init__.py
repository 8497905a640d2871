"""The order of the stages, and nothing else."""

from .explaining import Explained as Explained
from .explaining import explain_scan as explain_scan
from .fit import fit_scan as fit_scan
from .formats import FORMATS as FORMATS
from .formats import Format as Format
from .formats import check_formats as check_formats
from .formats import format_of as format_of
from .meshes import with_meshes as with_meshes
from .outputs import write_outputs as write_outputs
from .provenance import package_version as package_version
from .tape import held_again as held_again
from .tape import with_tape as with_tape
from .truth import truth_result as truth_result
from .versus import Versus as Versus
from .versus import fit_both as fit_both
