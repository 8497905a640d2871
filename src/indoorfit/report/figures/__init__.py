"""Figures for papers: vector or pixels, sized for a column of text. Matplotlib is loaded on first use."""

from .histogram import residual_histogram as residual_histogram
from .normals import normal_scatter as normal_scatter
from .paper import FIGURE_FORMATS as FIGURE_FORMATS
from .paper import FigureFormat as FigureFormat
from .paper import figure_bytes as figure_bytes
from .steps import step_figures as step_figures
from .trace import GreedyTrace as GreedyTrace
