"""Labelled segments -> the cube grammar of every room."""

from .cuts import Trial as Trial
from .discover import DiscoverConfig as DiscoverConfig
from .discover import discover as discover
from .explanation import Beside as Beside
from .explanation import CandidateReport as CandidateReport
from .explanation import Explanation as Explanation
from .explanation import explain as explain
from .overrides import PlanOverrides as PlanOverrides
from .overrides import WallStretch as WallStretch
