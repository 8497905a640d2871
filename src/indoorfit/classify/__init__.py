"""Segments -> front, back, left, right, floor, ceiling."""

from .table import ClassifyConfig as ClassifyConfig
from .table import classify as classify
