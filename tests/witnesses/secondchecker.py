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


_CELLS = """
const fs = require("fs");
const text = fs.readFileSync(process.argv[1], "utf8");
const inside = text
  .replace("return { verdict,", "return { waveFactor, Fraction, Refused, verdict,")
  .replace(/\\.\\.\\.common,\\s+cost,\\s+signs\\(a, b\\) \\{\\s+if \\(!a.n\\) return signsFrom0/, "all, modelOf, $&");
const checker = { exports: {} };
new Function("module", inside)(checker);
const { waveFactor, Fraction, Refused } = checker.exports;
const number = (x) => new Fraction(...x.split("/").map(BigInt), ...(x.includes("/") ? [] : [1n]));
function tried(work) {
  try { return work(); } catch (error) { if (error instanceof Refused) return null; throw error; }
}
const said = JSON.parse(fs.readFileSync(0, "utf8")).map(([told, delays, orders, a, b]) => {
  const f = waveFactor(told, delays.map(number), orders.map(number));
  const [low, high] = [a, b].map(number);
  const model = low.n ? tried(() => f.modelOf(f.all, low, high)) : null;
  const signs = tried(() => f.signs(low, high));
  return [model && [model[0].map(String), String(model[1])], signs && [`${signs[0].n}/${signs[0].d}`, signs[1]]];
});
process.stdout.write(JSON.stringify(said));
"""


def cells(asked: Sequence[Any], seconds: float = 300) -> list[list[Any]]:
    """Of factors with waves in cells: the coefficients of their models with what these are off by, and the signs; None where refused."""
    return run(_CELLS, list(asked), seconds)  # type: ignore[no-any-return]


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
