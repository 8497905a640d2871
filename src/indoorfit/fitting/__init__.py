"""Points and a grammar -> fitted planes with their uncertainty."""

from .association import AssociationConfig as AssociationConfig
from .association import associate as associate
from .belief import Belief as Belief
from .belief import BeliefConfig as BeliefConfig
from .belief import believe as believe
from .frames import cells_by_frame as cells_by_frame
from .greedy import GreedyConfig as GreedyConfig
from .greedy import GreedyFit as GreedyFit
from .greedy import fit_greedy as fit_greedy
from .intervals import Intervals as Intervals
from .intervals import intervals as intervals
from .joint import JointConfig as JointConfig
from .joint import JointFit as JointFit
from .joint import fit_joint as fit_joint
from .motions import frame_motions as frame_motions
from .motions import register as register
from .patches import PatchData as PatchData
from .residuals import build_cells as build_cells
from .uncertainty import Cells as Cells
