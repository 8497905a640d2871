"""The order of the stages, and nothing else."""

from .fit import fit_scan as fit_scan
from .outputs import write_outputs as write_outputs
from .truth import truth_result as truth_result
from .versus import Versus as Versus
from .versus import fit_both as fit_both
