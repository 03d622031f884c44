"""The checker of a report page, run by Node: what it says of certificates."""

from __future__ import annotations

import json
import shutil
import subprocess
import tomllib
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from marks import required

CHECKER = Path(str(files("haptisym") / "data" / "checker.js"))
_RUN = """
const checker = require(process.argv[1]);
const { asked, catalogue } = JSON.parse(require("fs").readFileSync(0, "utf8"));
const said = asked.map(([proof, scene]) => checker.verdict(proof, scene, catalogue)).map(({ claim, why }) => [claim, why]);
process.stdout.write(JSON.stringify(said));
"""


def verdicts(asked: Sequence[tuple[str, str]], seconds: float = 300) -> list[list[Any]]:
    """Of each certificate and scene text the claim, None where it is not proven, and why not."""
    return run(_RUN, {"asked": list(asked), "catalogue": catalogue()}, seconds)  # type: ignore[no-any-return]


def catalogue() -> dict[str, Any]:
    """The units and models of scene files."""
    return tomllib.loads((files("haptisym_check") / "catalogue.toml").read_text(encoding="utf-8"))


def run(code: str, given: Any, seconds: float) -> Any:
    """What a script prints, with the checker's path as its argument; it has that time, and 1 GB."""
    node = shutil.which("node")
    required("node", node)
    command = [str(node), "--max-old-space-size=1000", "-e", code, str(CHECKER)]
    done = subprocess.run(
        command, input=json.dumps(given), capture_output=True, text=True, check=False, timeout=seconds
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
