"""What the intervals do not say: tests of their assumptions, each a warning with numbers and advice."""

from .config import HonestyConfig as HonestyConfig
from .evidence import Evidence as Evidence
from .notes import honesty_notes as honesty_notes
