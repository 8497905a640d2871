"""Surfels -> planar segments, and connected components of what remains."""

from .growing import SegmentConfig as SegmentConfig
from .growing import grow_surfaces as grow_surfaces
