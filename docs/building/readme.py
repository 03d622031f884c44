"""The README as a package index shows it: its links and images are absolute, where the project has an address.

Hatchling calls this for every wheel and source archive. The addresses are those of ``[project.urls]``: ``Repository`` for
files (as GitHub, GitLab and Codeberg name them), ``Documentation`` for the page in the browser; without them the text is as
it is in the repository.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

SERVED = "http://localhost:8000"
"""The address that the README names for a site that is served from a laptop."""


class AbsoluteLinks(MetadataHookInterface):
    """Writes the README into the metadata."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the key ``readme``."""
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        made = absolute(text, metadata.get("urls", {}), metadata["version"])
        metadata["readme"] = {"content-type": "text/markdown", "text": made}


def absolute(text: str, urls: dict[str, str], version: str) -> str:
    """Return the README with absolute links, as far as the addresses are known."""
    if site := urls.get("Documentation"):
        text = text.replace(SERVED, site.rstrip("/"))
    if repository := urls.get("Repository"):
        for start, folder in (("!", "raw"), ("(?<!!)", "blob")):
            place = f"{repository.rstrip('/')}/{folder}/v{version}/"
            text = re.sub(rf"({start}\[[^\]]*\]\()(?!https?:|#)", rf"\g<1>{place}", text)
    return text
