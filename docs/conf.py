"""The site: ``python -m sphinx -W -n docs build/site``. Its pages request nothing from outside: formulas are MathML.
``try/`` runs the package itself (``building/inbrowser.py``).

Sources are the pages of this folder, the script ``plots.py``, which is run, and ``generated/``, which ``building/`` writes
from the package for every build.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE / "building")]

import docstrings  # noqa: E402
import formulas  # noqa: E402
import generated  # noqa: E402
import inbrowser  # noqa: E402
import measured  # noqa: E402

import haptisym as hs  # noqa: E402

if TYPE_CHECKING:
    from sphinx.application import Sphinx

project = "haptisym"
version = release = hs.__version__
copyright = "the authors of haptisym"  # noqa: A001
extensions = ["myst_nb", "sphinx.ext.autodoc"]
nb_custom_formats = {".py": ["cells.read", {}]}
nb_execution_mode = "cache"
nb_execution_cache_path = os.environ.get("HAPTISYM_CELLS", str(HERE.parent / "build" / "cells"))
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True
exclude_patterns = ["building", "try", "conf.py", "house.py", "make_notebook.py", "reproductions/book.py"]
source_suffix = {".md": "myst-nb", ".py": "myst-nb"}
myst_enable_extensions = ["dollarmath"]
myst_disable_syntax = ["myst_line_comment"]  # a line may begin with a per cent sign
myst_heading_anchors = 3
suppress_warnings = ["mystnb.unknown_mime_type"]

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
nitpick_ignore_regex = [
    # types of other packages, of the package's own inside, and of what a signature calls by a short name
    (r"py:.*", r"(?!haptisym\.\w+$).*")
]

html_theme = "furo"
html_title = f"haptisym {release}"
html_static_path = ["building/static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False


def setup(app: Sphinx) -> dict[str, Any]:
    """Formulas as MathML, docstrings as the prose that they are, measured numbers, and the pages that are written anew."""
    formulas.setup(app)
    docstrings.setup(app)
    app.connect(
        "source-read",
        lambda _app, name, text: text.__setitem__(0, generated.linked(measured.with_numbers(name, text[0]))),
    )
    app.connect("config-inited", lambda *_: generated.write(HERE / "generated"))
    app.connect("build-finished", lambda _app, error: error or inbrowser.place(inbrowser.FOLDER, Path(app.outdir)))
    return {"parallel_read_safe": True}
