"""Print the lowest version of each dependency that pyproject.toml allows, one a line: a file of constraints for pip.

.ci/run installs them so that a lower bound is a claim that is tested.
"""

import re
import tomllib
from pathlib import Path

project = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
rows = [*project["dependencies"], *(row for extra in project["optional-dependencies"].values() for row in extra)]
for name, least in sorted(
    {found.groups() for row in rows if (found := re.match(r"([\w-]+)(?:\[\w+\])?>=(\S+)$", row))}
):
    print(f"{name}=={least}")
