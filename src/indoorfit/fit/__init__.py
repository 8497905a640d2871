"""Points and a grammar -> fitted planes with their uncertainty."""

from .association import AssociationConfig as AssociationConfig
from .association import PatchData as PatchData
from .association import associate as associate
from .greedy import GreedyConfig as GreedyConfig
from .greedy import GreedyFit as GreedyFit
from .greedy import fit_greedy as fit_greedy
from .intervals import IntervalConfig as IntervalConfig
from .intervals import Intervals as Intervals
from .intervals import edge_exchange_std as edge_exchange_std
from .intervals import intervals as intervals
from .joint import JointConfig as JointConfig
from .joint import JointFit as JointFit
from .joint import fit_joint as fit_joint
from .residuals import build_cells as build_cells
from .uncertainty import Cells as Cells
