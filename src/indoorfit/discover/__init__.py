"""Labelled segments -> the cube grammar of every room."""

from .discover import DiscoverConfig as DiscoverConfig
from .discover import discover as discover
