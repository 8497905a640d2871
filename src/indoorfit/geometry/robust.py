"""Spread that gross errors do not move."""

MAD_TO_STD = 1.4826
"""Standard deviation of normal errors over their median absolute deviation: 1 / Phi^-1(3/4)."""
