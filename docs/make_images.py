"""The pictures of README.md, made by the program itself from its own demonstration.

python docs/make_images.py
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).with_name("images")
WIDTH_PIXELS = 900
COLOURS = 64
"""Flat drawings need no more; files stay around 30 kB."""


def main() -> None:
    """Run `indoorfit demo` and keep its plan and its view, small."""
    IMAGES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "demo"
        command = [sys.executable, "-m", "indoorfit", "demo", "--out", str(out), "--quiet"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        for name in ("plan", "view"):
            with Image.open(out / f"{name}.png") as picture:
                height = round(picture.height * WIDTH_PIXELS / picture.width)
                small = picture.convert("RGB").resize((WIDTH_PIXELS, height), Image.Resampling.LANCZOS)
            small.quantize(COLOURS).save(IMAGES / f"demo-{name}.png", optimize=True)


if __name__ == "__main__":
    main()
