"""Khronos' validator of glTF, where node and the npm package gltf-validator are installed."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

_SCRIPT = (
    "const v = require(process.argv[1]); const fs = require('fs');"
    "v.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])))"
    ".then(r => console.log(JSON.stringify(r.issues)))"
)


def assert_nothing_found(path: Path, *but: str) -> None:
    """No error, warning, information or hint other than those with the codes that are named.

    INDOORFIT_NODE_MODULES names the folder of the package.
    """
    modules = os.environ.get("INDOORFIT_NODE_MODULES", "node_modules")
    package = os.path.abspath(os.path.join(modules, "gltf-validator"))
    if shutil.which("node") is None or not os.path.isdir(package):
        pytest.skip("no node, or no gltf-validator: npm install gltf-validator")
    done = subprocess.run(
        ["node", "-e", _SCRIPT, package, str(path)], capture_output=True, text=True, check=True, timeout=60
    )
    issues = json.loads(done.stdout)
    assert [message for message in issues["messages"] if message["code"] not in but] == []
    assert (issues["numErrors"], issues["numWarnings"], issues["truncated"]) == (0, 0, False)
