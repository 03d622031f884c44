"""Every verb writes its page as LaTeX and as a report, by the same two options."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from pkgutil import resolve_name

import pytest
from marks import often
from pagereader import Page

from haptisym.cli import VERBS

CALLS = {
    "evaluate": "evaluate delayed-spring",
    "family": "evaluate palpation-device",
    "derive": "derive fu2019 --keep omega_n",
    "effects": "effects sidestick",
    "require": "require fu2019 --free zeta",
    "sensitivity": "sensitivity fu2019",
    "tolerances": "tolerances fu2019-tolerances --samples 3",
    "sweep": "sweep fu2019 --vary effects.filter.omega_n=40:200:3",
    "metrics": "metrics fu2019",
    "simulate": "simulate fu2019",
}
Call = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize("name", often(CALLS, {"require", "sensitivity", "family"}.__contains__))
def test_a_verb_writes_its_page_and_prints_the_same_answer(name: str, call: Call, tmp_path: Path) -> None:
    tex, html = tmp_path / "x.tex", tmp_path / "x.html"
    status, out, err = call(*CALLS[name].split(), "--json", "--latex", str(tex), "--report", str(html))
    assert (status, err) == (0, f"LaTeX written to {tex}\nreport written to {html}\n")
    document, read = json.loads(out), Page(html.read_text(encoding="utf-8"))
    assert read.loads == []
    assert document["title"] in "".join(read.texts)
    [held] = re.findall(
        r'<script type="application/json" id="\w+">({"schema".*?)</script>', html.read_text(encoding="utf-8")
    )
    assert json.loads(held)["schema"] == document["schema"]
    written = tex.read_text(encoding="ascii")
    assert written.count(r"\begin{document}") == 1
    assert written.count(r"\begin{table}") == written.count(r"\end{table}")


def test_every_verb_that_answers_has_both_options() -> None:
    for name in VERBS:
        command = resolve_name(f"haptisym.commands.{name}:{name}")
        options = {x for p in command.params for x in p.opts}
        assert ({"--latex", "--report"} <= options) == (name not in ("scenes", "schemas")), name


def test_a_wrong_name_is_told_before_the_work_begins(call: Call, tmp_path: Path) -> None:
    status, out, err = call("require", "fu2019", "--free", "zeta", "--report", str(tmp_path / "x.docx"))
    assert (status, out, err) == (2, "", 'error: report: the name "x.docx" must end in .html or .pdf\n')
