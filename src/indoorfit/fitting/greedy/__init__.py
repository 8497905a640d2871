"""The thesis' own procedure: largest cube, then cubes from intersection points (3.2.2 to 3.2.5)."""

from .config import GreedyConfig as GreedyConfig
from .greedy import fit_greedy as fit_greedy
from .record import Action as Action
from .record import FittedPlane as FittedPlane
from .record import GreedyFit as GreedyFit
from .record import GreedyStep as GreedyStep
