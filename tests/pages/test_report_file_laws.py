"""Reports as files: drawings within a page, and how a document is given to what sets it, which is made by hand here."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from types import SimpleNamespace as Made
from typing import Any

import pytest
from matplotlib.figure import Figure as Canvas

from haptisym import __version__
from haptisym.figures import pen
from haptisym.kernel.errors import NothingToDrawError, SceneError
from haptisym.pages import report
from haptisym.writing.document import Document, Figure, Paragraph, Section

RECORD = '{"schema": "haptisym.peaks/1", "value": 0.1}'


def drawing() -> Canvas:
    canvas = Canvas(figsize=(2, 1))
    axes = canvas.add_subplot()
    axes.plot([0, 1], [0, 1], color=pen.BLUE)
    axes.set_title("label")
    return canvas


def nothing() -> Canvas:
    raise NothingToDrawError("no value")


def document(*figures: Figure) -> Document:
    return Document("Title", ("source",), (Paragraph("Words."), *figures), "Peaks")


FIGURE = Figure("small", "What it shows < 3", drawing)


# On a page


def test_a_page_holds_the_record_under_the_name_of_its_schema_and_says_by_what_it_was_made(tmp_path: Path) -> None:
    target = tmp_path / "page.html"
    report.save(document(FIGURE), RECORD, target)
    text = target.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="peaks">(.*?)</script>', text)
    assert found
    assert json.loads(found[1]) == json.loads(RECORD)
    assert f"Made by haptisym {__version__}." in text
    assert "<h1>Title</h1>" in text
    with pytest.raises(SceneError):
        report.save(document(), RECORD, tmp_path / "page.txt")


@pytest.mark.parametrize("wide", [True, False])
def test_a_drawing_is_part_of_the_page_with_its_caption_and_its_own_names(wide: Any) -> None:
    text = str(report._drawn(Figure("small", "What it shows < 3", drawing, wide)))
    assert text.startswith(f'<figure class="{"wide" if wide else "small"}"><svg ')
    assert text.endswith("<figcaption>What it shows &lt; 3</figcaption></figure>")
    assert 'role="img"><title>What it shows &lt; 3</title>' in text
    assert report._drawn(Figure("none", "x", nothing)) == ""


def test_of_a_drawing_its_prologue_comments_size_and_colours_are_taken_away_and_names_are_its_own() -> None:
    svg = report._svg(drawing())
    inline = str(report._inline(svg, "mine", "a label"))
    assert inline.startswith("<svg ")
    head = inline[: inline.index(">")]
    assert (svg.count("<!--") > 0, svg.count("<metadata>") > 0) == (True, True)
    for gone in ("<!--", "<?xml", "<!DOCTYPE", "<metadata", "<style", "\n"):
        assert gone not in inline
    assert not re.search(r" (width|height)=", head)
    assert "viewBox" in head
    names = re.findall(r'\bid="([^"]*)"', inline)
    assert names
    assert all(x.startswith("mine-") for x in names)
    for used in re.findall(r'(?:url\(#|xlink:href="#)([^")]*)', inline):
        assert used in names
    assert pen.BLUE not in inline
    assert "var(--env)" in inline
    small = report._inline(
        '<?xml?><svg width="1" height="2" x="3">\n  <!-- no\n-->  <g id="a" fill="#ffffff"/>\n<style>b</style></svg>',
        "n",
        "<l>",
    )
    assert small == '<svg x="3" role="img"><title>&lt;l&gt;</title> <g id="n-a" fill="var(--paper)"/> </svg>'


# As a PDF


class Setter:
    """In the place of pdflatex: it notes what it is asked for and makes a file."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *, code: int = 0, told: str = "", late: bool = False) -> None:
        self.calls: list[tuple[list[str], dict[str, Any]]] = []
        self.files: set[str] = set()
        self.code, self.told, self.late = code, told, late
        monkeypatch.setattr(report, "which", lambda name: f"/bin/{name}")
        monkeypatch.setattr(subprocess, "run", self)

    def __call__(self, command: list[str], **given: Any) -> Any:
        self.calls.append((command, given))
        folder = Path(given["cwd"])
        self.files = {x.name for x in folder.iterdir()} - {"report.pdf"}
        (folder / "report.pdf").write_bytes(b"%PDF" + str(len(self.calls)).encode())
        if self.late:
            raise subprocess.TimeoutExpired(command, given["timeout"])
        return Made(returncode=self.code, stdout=self.told.encode())


def test_a_document_is_set_twice_in_a_folder_of_its_own_that_is_gone_afterwards(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    setter = Setter(monkeypatch)
    own = document(FIGURE, Figure("none", "x", nothing))
    target = tmp_path / "out.PDF"
    report.save(own, RECORD, target)
    assert target.read_bytes() == b"%PDF2"  # that of the second run, which knows the numbers of the tables
    assert [command for command, _ in setter.calls] == [
        ["/bin/pdflatex", "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "report.tex"]
    ] * 2
    for _, given in setter.calls:
        assert given["env"]["FORCE_SOURCE_DATE"] == "1"
        assert given["timeout"] == 300
        assert given["check"] is False
        assert given["capture_output"] is True
        assert given["stdin"] == subprocess.DEVNULL
        assert not Path(given["cwd"]).exists()
    assert setter.files == {"report.tex", "small.pdf"}


def test_the_figures_of_all_sections_are_files_but_for_those_that_have_nothing_to_draw(tmp_path: Path) -> None:
    own = document(FIGURE, Figure("none", "x", nothing))
    nested = Document("T", (), (*own.blocks, Section("S", (Figure("deep", "x", drawing),))))
    assert report._figures(nested, tmp_path) == {"small": "small.pdf", "deep": "deep.pdf"}
    assert {x.name for x in tmp_path.iterdir()} == {"small.pdf", "deep.pdf"}


@pytest.mark.parametrize(
    ("told", "shown"),
    [
        ("This is TeX\n! Undefined control.\nl.5\n! Emergency stop.\n", "! Undefined control. ! Emergency stop."),
        ("one\ntwo\nlast words", "last words"),
        ("", ""),
    ],
)
def test_what_the_setter_finds_wrong_is_told_by_its_own_words(
    told: str, shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    Setter(monkeypatch, code=1, told=told)
    with pytest.raises(SceneError) as raised:
        report.pdf(document())
    assert str(raised.value) == f"report: pdflatex could not set the document: {shown}"


def test_a_setter_that_is_missing_or_not_done_in_time_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    Setter(monkeypatch, late=True)
    with pytest.raises(SceneError, match="pdflatex was not done after 300 s"):
        report.pdf(document())
    monkeypatch.setattr(report, "which", lambda _: None)
    with pytest.raises(SceneError, match="a PDF needs pdflatex, which was not found"):
        report.pdf(document())
