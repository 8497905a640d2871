"""The 3D view of the page, and the scripts that bring it and the tables to life."""

import base64
import hashlib
import json
from pathlib import Path
from typing import Any

_FOLDER = Path(__file__).with_name("viewer")
_SCRIPTS = ("three.min.js", "page.js", "scene.js")
"""In the order in which the page runs them; the first is three.js (MIT), the others are indoorfit's own."""

VIEW = """<section id="view" aria-label="3D view"><h2>3D view</h2>
<div class="tools" role="toolbar" aria-label="3D view">
<button type="button" id="orbit" aria-pressed="true">Orbit</button>
<button type="button" id="walk" aria-pressed="false">Walk inside</button>
<button type="button" id="home">Start view</button>
<label><input type="checkbox" id="textures" checked> Textures</label>
<label><input type="checkbox" id="lengths" checked> Dimensions</label>
<label><input type="checkbox" id="names" checked> Names</label>
<label class="slide">Cut <input type="range" id="cut" min="0" max="100" value="100" step="1"
 aria-label="Height at which the model is cut"> <output id="cut-says" for="cut"></output></label>
</div>
<div id="stage"><canvas tabindex="0" role="application" aria-roledescription="3D view"
 aria-label="The measured rooms in 3D" aria-describedby="keys"></canvas>
<div class="labels" aria-hidden="true"></div></div>
<p id="says" role="status" aria-live="polite">Choose a dimension in the table, or click a face, to see which
faces it belongs to.</p>
<p id="keys" class="quiet">Drag to turn, scroll or pinch to zoom, arrow keys and + and &minus; do the
same; Home goes back. Walls look inward: those between you and the room are not drawn. Inside, drag to look
around, click the floor to go there, or use W A S D and the arrow keys. Esc ends a selection.</p>
<p id="picked" hidden><span></span> <a href="#view">3D view</a> <a href="#plan">Plan</a>
<a href="#dimensions">Table</a> <button type="button">Clear</button></p>
<noscript><p class="warning">The 3D view needs scripts; plan and tables are complete without.</p></noscript>
</section>"""


def policy() -> str:
    """A content security policy: nothing is fetched, and no script runs but those of this package."""
    hashes = " ".join(f"'sha256-{_digest(text)}'" for text in _sources())
    return f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {hashes}"


def scripts(data: dict[str, Any]) -> str:
    """The data and the scripts; they belong at the end of the page.

    Args:
        data: plain values for JSON. Texts in it may hold anything: every ``<`` is written as an escape, so
            that none can end the element or begin another.
    """
    plain = json.dumps(data, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    plain = plain.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
    licence = " ".join((_FOLDER / "three.LICENSE.txt").read_text(encoding="utf-8").split())
    parts = [f'<script type="application/json" id="report-data">{plain}</script>']
    parts.append(f"<!-- The next script is three.js. {licence} -->")
    parts += [f"<script>{text}</script>" for text in _sources()]
    return "\n".join(parts)


def _sources() -> list[str]:
    return [(_FOLDER / name).read_text(encoding="utf-8") for name in _SCRIPTS]


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
