"""The hand-made rooms are shared with the tests of the export formats."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "export"))
