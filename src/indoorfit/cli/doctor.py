"""``indoorfit doctor``: what is installed, where caches are, and whether a fit comes out right."""

import json
import sys
from dataclasses import asdict, dataclass

from .maybe import Flag
from .runtime import set_up_logging


@dataclass(frozen=True)
class DoctorCommand:
    """Say which versions are installed and where the caches are, and fit a small simulated room as a test.

    Exit code 0 where all that is needed is there and the test came out right, else 1.
    """

    json: Flag = False
    """Print JSON."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=True, verbose=False)
        from .health import cache_facts, libraries, self_test

        found, caches, test = libraries(), cache_facts(), self_test()
        sound = test.ok and not any(library.problem for library in found if not library.extra)
        if self.json:
            document = {
                "ok": sound,
                "python": sys.version.split()[0],
                "platform": sys.platform,
                "libraries": [asdict(library) for library in found],
                "caches": [asdict(cache) for cache in caches],
                "self_test": asdict(test),
            }
            sys.stdout.write(json.dumps(document, indent=1) + "\n")
            return 0 if sound else 1
        lines = [f"Python {sys.version.split()[0]} on {sys.platform}", ""]
        width = max(len(library.name) for library in found)
        for library in found:
            extra = f"  [{library.extra}]" if library.extra else ""
            state = library.version or "not installed"
            lines.append(f"{library.name:{width}}  {state}{extra}  {library.problem}".rstrip())
        lines.append("")
        lines += [f"cache {c.name}: {c.place}, {c.files} files, {c.bytes / 1e6:.1f} MB" for c in caches]
        lines += ["", f"self-test: {'ok' if test.ok else 'FAILED'}: {test.message}"]
        sys.stdout.write("\n".join(lines) + "\n")
        return 0 if sound else 1
