"""Every verb writes its page as LaTeX and as a report, by the same two options."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from pkgutil import resolve_name

import browser
import pytest
from browser import Browser
from marks import often, required
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
    "map": "require fu2019 --free omega_n --free zeta --range 60 200 --range 0.1 1 --slices 3",
    "stability": "stability delayed-spring --hand firm-grip",
    "sweep": "sweep fu2019 --vary effects.filter.omega_n=40:200:3",
    "sweep over two": "sweep fu2019 --vary omega_n=40:200:3 --vary zeta=0.2:1:3",
    "cost": "cost fu2019 --quick",
    "metrics": "metrics fu2019",
    "simulate": "simulate fu2019",
}
Call = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize("name", often(CALLS, {"family"}.__contains__))
def test_a_verb_writes_its_page_and_prints_the_same_answer(name: str, call: Call, tmp_path: Path) -> None:
    tex, html = tmp_path / "x.tex", tmp_path / "x.html"
    status, out, err = call(*CALLS[name].split(), "--json", "--latex", str(tex), "--report", str(html))
    assert (status, err) == (0, f"LaTeX written to {tex}\nreport written to {html}\n")
    document, read = json.loads(out), Page(html.read_text(encoding="utf-8"))
    assert [x for x in read.loads if not x.startswith("data:")] == []
    assert document["title"] in "".join(read.texts)
    [held] = re.findall(
        r'<script type="application/json" id="\w+">({"schema".*?)</script>', html.read_text(encoding="utf-8")
    )
    assert json.loads(held)["schema"] == document["schema"]
    written = tex.read_text(encoding="ascii")
    assert written.count(r"\begin{document}") == 1
    assert written.count(r"\begin{table}") == written.count(r"\end{table}")


@pytest.fixture(scope="module")
def opened() -> Iterator[Browser]:
    required("chromium", browser.program())
    with browser.running() as started:
        yield started


@pytest.mark.slow
@pytest.mark.parametrize("name", often(CALLS, "stability".__eq__))
def test_a_browser_shows_all_that_a_report_holds(name: str, call: Call, opened: Browser, tmp_path: Path) -> None:
    """Drawings with a ground of pixels too, which the page's own policy once forbade."""
    html = tmp_path / "x.html"
    assert call(*CALLS[name].split(), "--report", str(html))[0] == 0
    opened.open(html)
    assert opened.complaints() == []
    assert len(opened.requests()) == 1


@pytest.mark.slow
def test_what_is_drawn_of_a_hand_takes_the_colours_of_the_page(call: Call, tmp_path: Path) -> None:
    """In the dark too: no ground of white pixels under light ink."""
    html = tmp_path / "x.html"
    assert call(*CALLS["stability"].split(), "--report", str(html))[0] == 0
    text = html.read_text(encoding="utf-8")
    assert "<image" not in text
    assert "fill: var(--unstable)" in text


def test_every_verb_that_answers_has_both_options() -> None:
    for name in VERBS:
        command = resolve_name(f"haptisym.commands.{name}:{name}")
        options = {x for p in command.params for x in p.opts}
        assert ({"--latex", "--report"} <= options) == (name not in ("scenes", "schemas")), name


def test_a_wrong_name_is_told_before_the_work_begins(call: Call, tmp_path: Path) -> None:
    status, out, err = call("require", "fu2019", "--free", "zeta", "--report", str(tmp_path / "x.docx"))
    assert (status, out, err) == (2, "", 'error: report: the name "x.docx" must end in .html or .pdf\n')


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
def test_no_table_of_a_report_has_to_be_scrolled_on_a_desk(
    name: str, call: Call, opened: Browser, tmp_path: Path
) -> None:
    also = ["--regions"] if name in ("evaluate", "family") else []
    page = tmp_path / "x.html"
    call(*CALLS[name].split(), *also, "--report", str(page))
    opened.open(page)
    opened.look(1000)
    scrolled = "[...document.querySelectorAll('.scroll')].filter(x => x.scrollWidth > x.clientWidth)"
    assert opened.value(scrolled + ".map(x => x.textContent.slice(0, 80))") == []
