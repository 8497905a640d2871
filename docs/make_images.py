"""The pictures of README.md, made by the program itself from its own demonstration.

python docs/make_images.py (with Chromium installed, for the picture of the report)
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).with_name("images")
WIDTH_PIXELS = 900
COLOURS = 64
"""Flat drawings need no more; files stay around 30 kB. The report has textures and gets 256."""


def main() -> None:
    """Run `indoorfit demo` and keep its plan, its view and its report, small."""
    IMAGES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "demo"
        command = [sys.executable, "-m", "indoorfit", "demo", "--out", str(out), "--quiet"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        photograph(out / "report.html", out / "report.png")
        for name in ("plan", "view", "report"):
            with Image.open(out / f"{name}.png") as picture:
                height = round(picture.height * WIDTH_PIXELS / picture.width)
                small = picture.convert("RGB").resize((WIDTH_PIXELS, height), Image.Resampling.LANCZOS)
            small.quantize(256 if name == "report" else COLOURS).save(
                IMAGES / f"demo-{name}.png", optimize=True
            )


def photograph(page: Path, picture: Path) -> None:
    """The top of a page as Chromium shows it."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("make_images: Chromium is needed for the picture of the report. Fix: install it.")
    flags = ["--headless=new", "--no-sandbox", "--hide-scrollbars", "--window-size=1180,1000"]
    flags += ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    command = [chromium, *flags, "--virtual-time-budget=5000", f"--screenshot={picture}", page.as_uri()]
    subprocess.run(command, check=True, capture_output=True, timeout=60)


if __name__ == "__main__":
    main()
