"""The command line as a user meets it: questions, documents and pages, and what it refuses before any work."""

from __future__ import annotations

import copy
import json
import os
import pickle
import re
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import count
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import browser
import pytest
from browser import Browser
from flint import Ordering, acb, arb, arb_mat, arb_poly, fmpq, fmpq_mpoly_ctx, fmpq_poly, fmpz_poly
from marks import required
from pagereader import Page

import haptisym as hs
from haptisym.cli import LIGHT, VERBS
from haptisym.commands import shipped, verbs
from haptisym.kernel.budget import timed_by
from haptisym.kernel.objects import packed, unpacked
from haptisym.model.files import write_whole
from haptisym.verbs.jnd.tables import Answers, LevelAnswers
from haptisym.writing.schemas import json_schema, schema_names


def test_the_contract_document_of_the_papers_example(call) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call("evaluate", "fu2019", "--json")
    document = json.loads(out)
    assert (status, err) == (0, "")
    enclosures = [crossing.pop("enclosure") for crossing in document["crossings"]]
    assert [
        float(low) <= omega <= float(high)
        for (low, high), omega in zip(enclosures, (7.978916790174708, 11.937310924322059), strict=True)
    ]
    assert document == {
        "schema": "haptisym.evaluation/1",
        "title": "Numerical example of Fu, van Paassen and Mulder (2019)",
        "band": [0.0, 15.0],
        "threshold": {"real": "1/10", "imag": "1/10"},
        "crossings": [
            {
                "part": "real",
                "omega": 7.978916790174708,
                "digits": "7.97891679017471",
                "kind": "exceeds",
                "sign": 1,
                "multiplicity": 1,
            },
            {
                "part": "imag",
                "omega": 11.937310924322057,
                "digits": "11.9373109243221",
                "kind": "exceeds",
                "sign": 1,
                "multiplicity": 1,
            },
        ],
        "transparent": [[0.0, 7.978916790174708]],
        "bandwidth": 7.978916790174708,
        "changeovers": {"environment": [7.453559924999299], "perceived": [7.879481229194869]},
        "percepts": [
            {"part": "real", "band": [7.978916790174708, 15.0], "property": "mass", "change": "lower"},
            {"part": "imag", "band": [11.937310924322057, 15.0], "property": "damping", "change": "higher"},
        ],
        "outside_model": [],
        "unbounded": [],
        "stable": True,
        "any_environment": {"transparent_below": 7.92231185714061, "opaque_above": 11.100053432368274},
        "certified": True,
    }


def test_digits_are_as_many_as_asked_for(call) -> None:  # type: ignore[no-untyped-def]
    _, out, _ = call("evaluate", "fu2019", "--json", "--digits", "50")
    real, imag = json.loads(out)["crossings"]
    assert real["digits"] == "7.9789167901747077028158954471820345477715919238094"
    assert len(imag["digits"]) == 51


@pytest.mark.parametrize(
    "arguments",
    [("evaluate",), ("evaluat", "fu2019"), ("evaluate", "fu2019", "--digits", "0"), ("evaluate", "fu2019", "--jsn")],
)
def test_a_wrong_command_line_is_status_2_without_a_traceback(call, arguments) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*arguments)
    assert (status, out) == (2, "")
    assert "Error" in err


def test_a_shipped_scene_can_be_copied_and_is_the_same(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    status, text, _ = call("scenes", "fu2019")
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    copied = call("evaluate", str(tmp_path / "my.toml"), "--json")
    assert status == 0
    assert copied == call("evaluate", "fu2019", "--json")
    assert call("scenes", "no-such-scene")[0] == 2


TRANSPARENT = '[environment]\nmodel = "mass-spring-damper"\nk = {k}\n[[effects]]\nmodel = "delay"\ntau = "1 us"\n'


@pytest.mark.slow
@pytest.mark.parametrize(("verb", "k"), [("sensitivity", "100"), ("tolerances", '"100 N/m +- 5 %"')])
def test_an_answer_with_nothing_to_draw_is_given_all_the_same(call, tmp_path: Path, verb: str, k: str) -> None:  # type: ignore[no-untyped-def]
    scene, figure = tmp_path / "clear.toml", tmp_path / "figure.svg"
    scene.write_text(TRANSPARENT.format(k=k), encoding="utf-8")
    status, out, err = call(verb, str(scene), "--figure", str(figure))
    assert status == 2
    assert "Bandwidth" in out
    assert "no figure: " in err
    assert not figure.exists()


CLOCKED = """
environment = {{ {felt} }}
effects = [{{ model = "sampled-loop", T = "1 ms", method = "backward-difference" }}, {{ model = "shunt", m = "0.1 kg", b = 2 }}]
"""


@pytest.mark.parametrize(
    ("felt", "reason"),
    [
        ('model = "mass-spring-damper", k = 300', "stiffness and damping"),
        ('model = "expression", H = "k/(1 + b*s)", parameters = { k = 300, b = 0.002 }', "no linear function"),
        ('model = "kelvin-voigt", k = 300, b = 2', ""),
    ],
)
def test_a_plane_is_drawn_or_the_status_is_not_0(call, tmp_path: Path, felt: str, reason: str) -> None:  # type: ignore[no-untyped-def]
    scene, figure = tmp_path / "wall.toml", tmp_path / "plane.svg"
    scene.write_text(CLOCKED.format(felt=felt), encoding="utf-8")
    status, out, err = call("stability", str(scene), "--figure", str(figure))
    assert (status, figure.exists()) == ((2, False) if reason else (0, True))
    assert "Prescribed motion" in out
    assert reason in err
    assert err.startswith("no figure: " if reason else "figure written")


ASKED: dict[str, Callable[[str], Any]] = {
    "evaluate {} --digits 50 --tolerance 0.01 --regions": lambda x: hs.evaluate(x, 50, tolerance="0.01").with_regions(),
    "stability {} --hand postural-arm --digits 40": lambda x: hs.stability(x, hand="postural-arm", digits=40),
    "sensitivity {} --digits 30": lambda x: hs.sensitivity(x, 30),
    "effects {} --tolerance 0.05": lambda x: hs.relevance(x, "0.05"),
    "metrics {}": hs.metrics,
    "require {} --free omega_c": lambda x: hs.require(x, "omega_c"),
    "require {} --free omega_c --range 1 200 --part imag": lambda x: hs.require(
        x, "omega_c", (1, 200), part=hs.Part.IMAG
    ),
    "require {} --free omega_c --that stable --hand postural-arm": lambda x: hs.require(
        x, "omega_c", that="stable", hand="postural-arm"
    ),
    "derive {} --numeric": lambda x: hs.derive(x, ()),
    "derive {} --keep k": lambda x: hs.derive(x, ("k",)),
    "tolerances fu2019-tolerances --samples 3 --seed 4": lambda _: hs.tolerances("fu2019-tolerances", 3, 4),
    "evaluate palpation-device": lambda _: hs.evaluate_all("palpation-device"),
    "evaluate fu2019-bench": lambda _: hs.evaluate("fu2019-bench"),
    "identify fu2019-clipped-bench --effect second-order-lowpass": lambda _: hs.identify(
        "fu2019-clipped-bench", effects=["second-order-lowpass"]
    ),
    "jnd --published": lambda _: hs.published(),
}
"""Options that change the answer, and the question in Python."""


@pytest.mark.few(*[*ASKED][:10], "jnd --published")
@pytest.mark.parametrize("words", ASKED)
def test_every_option_reaches_its_question(call: Call, tmp_path: Path, words: str) -> None:
    scene = tmp_path / "mine.toml"
    scene.write_text(SCENE.replace("delay", "first-order-lag").replace('tau = "2 ms"', "omega_c = 20"), "utf-8")
    status, out, err = call(*words.format(scene).split(), "--json")
    assert (status, err) == (0, "")
    assert json.loads(out) == json.loads(ASKED[words](str(scene)).to_json())


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.parametrize("name", sorted(x.stem for x in (Path(hs.__file__).parent / "scenes").glob("*.toml")))
def test_every_shipped_scene_is_evaluated_in_a_document_that_its_schema_allows(call: Call, name: str) -> None:
    """The fixture holds the document against its schema."""
    status, out, err = call("evaluate", name, "--json")
    document = json.loads(out)
    assert (status, err, document["schema"]) == (0, "", "haptisym.evaluation/1")
    assert document["certified"]
    assert document["title"] == hs.load_scene(name).title


def test_what_a_limit_cuts_short_is_undecided_and_has_its_document_all_the_same(call: Call) -> None:
    with timed_by(count(0, 0.01).__next__):
        status, out, err = call("require", "delayed-spring", "--free", "tau", "--limit", "3", "--json")
    assert (status, err) == (3, "")
    assert not json.loads(out)["certified"]
    with timed_by(count().__next__):
        status, out, _ = call("require", "delayed-spring", "--free", "tau", "--limit", "1")
    assert status == 3
    assert "Undecided" in out


def test_scenes_and_schemas_are_listed_and_printed_as_they_are(call: Call) -> None:
    rows = json.loads(call("scenes", "--json")[1])["scenes"]
    assert len(rows) > 15
    loaded = [hs.load_scenes(x["name"]) for x in rows]
    assert [(x["title"], x["source"], x["environments"]) for x in rows] == [(x.title, x.source, len(x)) for x in loaded]
    assert [x["effects"] for x in rows] == [[e.name for e in x.first.effects] for x in loaded]
    assert all(f"  {x['name']} " in call("scenes")[1] for x in rows)
    listed = json.loads(call("schemas", "--json")[1])["schemas"]
    assert [x["name"] for x in listed] == [*schema_names()]
    assert json.loads(call("schemas", "evaluation")[1]) == json_schema("evaluation")


def test_every_verb_is_listed_once_and_helps(call: Call) -> None:
    status, out, _ = call("--help")
    listed = [x.split()[0] for x in out.partition("Commands:\n")[2].splitlines() if x.startswith("  ") and x[2] != " "]
    assert (status, listed) == (0, list(VERBS))
    assert call() == call("-h") == (0, out, "")
    for name, words in VERBS.items():
        assert (getattr(shipped if name in LIGHT else verbs, name).help or "").splitlines()[0] == words
    assert call("--version") == (0, f"haptisym {hs.__version__}\n", "")


SCENE = 'environment = { model = "maxwell", k = 100, b = 5 }\neffects = [{ model = "delay", tau = "2 ms" }]\n'


@pytest.mark.parametrize(
    "words",
    [
        ["evaluate", "{scene}", "--latex", "{scene}"],
        ["evaluate", "fu2019", "--environments", "fu2019", "{scene}", "--latex", "{same}"],
        ["evaluate", "{scene}", "--report", "{linked}"],
        ["simulate", "fu2019", "--motion", "{recording}", "--force", "{recording}"],
        ["effects", "{linked}", "--figure", "{scene}"],
        ["require", "{linked}", "--free", "k", "--figure", "{hard}"],
        ["sensitivity", "{scene}", "--figure", "{hard}"],
        ["sweep", "{hard}", "--vary", "environment.k=1:2:3", "--out", "{scene}"],
    ],
)
def test_no_output_takes_the_place_of_what_is_read_whatever_its_name(call, tmp_path: Path, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    scene, recording = tmp_path / "my.svg", tmp_path / "hand.csv"
    scene.write_text(SCENE, encoding="utf-8")
    recording.write_text("t,x\n0,0\n1,1\n", encoding="utf-8")
    linked, hard = tmp_path / "linked.html", tmp_path / "hard.pdf"
    linked.symlink_to(scene)
    os.link(scene, hard)
    names = {
        "scene": scene,
        "linked": linked,
        "hard": hard,
        "recording": recording,
        "same": tmp_path / "." / ".." / tmp_path.name / "my.svg",
    }
    status, out, err = call(*(word.format(**names) for word in words))
    assert (status, out) == (2, "")
    assert "is read by this very call, and would be overwritten: choose another name" in err
    assert scene.read_text(encoding="utf-8") == SCENE


@pytest.mark.parametrize(
    ("words", "way_out"),
    [
        ("my.toml", 'did you mean "haptisym evaluate my.toml"?'),
        ("evaluate fu2019 --hand firm-grip", "it is an option of compare, require, stability,"),
        ("evaluate fu2019 --latex x.pdf", "--report x.pdf"),
        ("require fu2019 --free zeta --that stabel", 'did you mean "stable"?'),
        ("require fu2019 --free stiffness", 'did you mean "environment.k"?'),
        ("require delayed-spring --free delay", 'did you mean "effects.delay.tau"?'),
    ],
)
def test_a_refusal_names_the_way_out(call, words: str, way_out: str) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words.split())
    assert (status, out) == (2, "")
    assert way_out in err


def test_two_outputs_are_not_written_to_one_file(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    one = str(tmp_path / "one.pdf")
    status, out, err = call("evaluate", "fu2019", "--certificate", one, "--report", one)
    assert (status, out) == (2, "")
    assert "--certificate and --report would both be written to" in err


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["require", "--help"]])
def test_help_that_cannot_be_written_is_told(call, monkeypatch: pytest.MonkeyPatch, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr("sys.stdout", None)
    status, _, err = call(*words)
    assert (status, err) == (2, "error: standard output cannot be written: it is closed\n")


@pytest.mark.parametrize(
    "words", [["evaluate", "--figures"], ["evaluate", "--latex"], ["sweep", "--vary=m=1:2:2", "--out"]]
)
def test_a_file_without_a_name_is_refused(call, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    assert call(words[0], "fu2019", *words[1:], "") == (2, "", f'error: {words[-1]} "": give a name\n')


def test_a_file_is_replaced_whole_or_stays_and_a_link_stays_one(tmp_path: Path) -> None:
    old, link = tmp_path / "a.csv", tmp_path / "link.csv"
    old.write_text("old")
    link.symlink_to(old)
    with pytest.raises(UnicodeEncodeError):
        write_whole(link, "x" * 99_999 + "\ud800")
    assert old.read_text() == "old"
    write_whole(link, "new")
    assert (link.is_symlink(), old.read_text(), {x.name for x in tmp_path.iterdir()}) == (
        True,
        "new",
        {"a.csv", "link.csv"},
    )


def test_figures_are_written_in_the_format_and_the_style_that_are_asked_for(call: Call, tmp_path: Path) -> None:
    one, folder = tmp_path / "mine", tmp_path / "all"
    words = ["--figure", str(one), "--figures", str(folder), "--format", "svg", "--style", "paper"]
    assert call("require", "fu2019", "--free", "zeta", *words)[0] == 0
    assert sorted(x.relative_to(tmp_path).as_posix() for x in tmp_path.rglob("*.*")) == ["all/worst.svg", "mine.svg"]
    drawn = (tmp_path / "mine.svg").read_text()
    colors = set(re.findall(r"#([0-9a-f]{6})", drawn))
    assert colors
    assert all(x[:2] == x[2:4] == x[4:] for x in colors)
    assert 'width="244.8pt"' in drawn  # 3.4 in


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
@pytest.mark.parametrize("name", ["latex a.tex", "report a.html", "certificate a.json", "response a.csv", "figures ."])
def test_where_there_is_no_room_the_old_file_stays(
    call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:  # type: ignore[no-untyped-def]
    import resource

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        sys, "dont_write_bytecode", True
    )  # what is imported here for the first time would be cut off, too
    old = tmp_path / name.partition(" ")[2].replace(".", "ratios.svg", name.endswith(" ."))
    old.write_text("old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        status, out, err = call("evaluate", "fu2019", f"--{name.partition(' ')[0]}", name.partition(" ")[2])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (status, out, "cannot be written: file too large" in err) == (2, "", True)
    assert (old.read_text(), [*tmp_path.iterdir()]) == ("old", [old])


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize(
    "words", [["evaluate", "fu2019", "--latex", "/dev/full"], ["simulate", "fu2019", "--force", "/dev/full"]]
)
def test_a_file_on_a_full_disk_is_named(call, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    assert err.lower().endswith(f"{words[-2][2:]}: /dev/full cannot be written: no space left on device\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("derive fu2019 --symbolic --numeric", "--symbolic and --numeric contradict each other"),
        ("derive fu2019 --json --to latex", "--json is one document"),
        ("derive fu2019 --json --to text", "--json is one document"),
        ("derive fu2019 --to c --of dH", "--of chooses among formulas"),
        ("derive fu2019 --to c --keep c", "evaluation.jnd is a threshold, of which code holds nothing"),
        ("metrics fu2019 --json --to latex", "--json prints one document"),
        ("metrics fu2019 --to text --json", "--json prints one document"),
        ("require fu2019 --free zeta --slices 5", "--slices is about a map"),
        ("require fu2019 --free zeta --part real --any-environment", "for any environment there are no parts"),
        ("tolerances fu2019-tolerances --samples 0 --seed 1", "--samples 0 draws none"),
        ("sweep fu2019 --vary evaluation.jnd=0.1:0.2:3 --workers 2 --cluster tcp://x", "--workers computes on this machine"),
        ("sweep fu2019 --vary evaluation.jnd=.1:.2:3 --vary environment.m=1:2:3 --vary environment.k=1:2:3 --figure a.svg", "one or two parameters, not 3"),
        ("sweep fu2019 --vary evaluation.jnd=.1:.2:3 --vary evaluation.jnd=.1:.2:3", "each path may be given only once"),
        ("sweep fu2019 --vary evaluation.jnd=0.1:0.2:3 --workers 2", "--workers and --cluster need --out"),
        ("cost --hard-cases --environment liver", "--hard-cases brings its own scenes"),
        ("cost --hard-cases --quick", "--hard-cases brings its own scenes"),
        ("cost fu2019 --hard-cases", "--hard-cases brings its own scenes"),
        ("cost", "name a SCENE, or ask for --hard-cases"),
        ("evaluate fu2019 sidestick", "unexpected argument (sidestick)"),
        ("evaluate palpation-device --tolerance 0.1", "--tolerance takes one environment"),
        ("require fu2019 --free zeta --free omega_n", "needs a --range for each"),
        ("require fu2019 --free zeta --range 0 1 --range 1 2", "--range not at all or as often"),
        ("derive fu2019 --keep m --numeric", "--keep gives the parameters that stay symbols, and so does --numeric"),
        ("simulate fu2019 --check --motion sine", "--check chooses the motion itself"),
        ("simulate fu2019 --lowpass-order 2", "it needs --lowpass"),
        ("scenes fu2019 --json", "leave out --json"),
        ("evaluate fu2019 --digits 20 --digits 30", "--digits is given 2 times"),
        ("evaluate fu2019 --style paper", "--style is about figures: it needs --figure or --figures"),
        ("evaluate fu2019 --figure a.svg --format pdf", '"a.svg" must end in .pdf as the format is pdf'),
        ("effects fu2019 --figure a.svg --figure b.svg", "--figure is given 2 times"),
    ],
)  # fmt: skip
def test_options_that_contradict_each_other_or_would_be_ignored_are_refused(call, words: str, said: str) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*words.split())
    assert (status, out) == (2, "")
    assert said in err


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


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
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


def test_every_verb_that_answers_has_both_options() -> None:
    for name in VERBS:
        command = getattr(shipped if name in LIGHT else verbs, name)
        options = {x for p in command.params for x in p.opts}
        assert ({"--latex", "--report"} <= options) == (name not in ("scenes", "schemas")), name


@pytest.mark.slow
@pytest.mark.parametrize("name", ["evaluate", "family", "map", "sweep over two"])
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


ARM = hs.hands["postural-arm"]


ANSWERS: dict[str, Callable[[], Any]] = {
    "evaluate": lambda: hs.evaluate("fu2019", 20, tolerance="1 %"),
    "evaluate, delayed": lambda: hs.evaluate("delayed-spring").with_regions(),
    "evaluate, fractional": lambda: hs.evaluate("organ-tissue"),
    "evaluate_all": lambda: hs.evaluate_all("palpation-device"),
    "evaluate, measured": lambda: hs.evaluate("fu2019-bench"),
    "derive": lambda: hs.derive("fu2019"),
    "peaks": lambda: hs.peaks("fu2019"),
    "metrics": lambda: hs.metrics("delayed-spring"),
    "metrics, with a free response": lambda: hs.metrics("fu2019"),
    "relevance": lambda: hs.relevance("control-stick-in-detail"),
    "stability": lambda: hs.stability("delayed-spring", hand=ARM),
    "stability, neutral": lambda: hs.stability("satellite-contact", hand=ARM),
    "stability, with a clock": lambda: hs.stability("virtual-wall", hand=ARM),
    "sensitivity": lambda: hs.sensitivity("delayed-spring"),
    "require": lambda: hs.require("fu2019", "omega_n"),
    "require, of a delay": lambda: hs.require("delayed-spring", "tau", that=["transparent", "stable"], hand=ARM),
    "require, passive": lambda: hs.require("virtual-wall", "environment.b", that="passive"),
    "design_map": lambda: hs.design_map("fu2019", ["omega_n", "zeta"], [(60, 200), ("0.1", 1)]),
    "tolerances": lambda: hs.tolerances("fu2019-tolerances"),
    "sweep": lambda: hs.sweep("fu2019", {"omega_n": [50, 100]}),
    "check": lambda: hs.check("fu2019"),
    "release": lambda: hs.release("delayed-spring", "1 cm", ARM),
    "cost": lambda: hs.cost("fu2019"),
    "published": hs.published,
    "jnd": lambda: hs.jnd(
        Answers(
            "answers", tuple(LevelAnswers(x, k, 40) for x, k in [(4.4, 5), (4.7, 11), (5.0, 19), (5.3, 26), (5.6, 33)])
        )
    ),
    "identify": lambda: hs.identify("fu2019-clipped-bench", effects=["second-order-lowpass"]),
}


def says(answer: Any) -> str:
    return str(answer.to_json() if hasattr(answer, "to_json") else answer)


@pytest.mark.few("metrics", "published")
@pytest.mark.parametrize("asked", ANSWERS)
def test_a_pickled_answer_of_every_verb_says_the_same(asked: str) -> None:
    answer = ANSWERS[asked]()
    told = says(answer)
    for other in (pickle.loads(pickle.dumps(answer)), copy.copy(answer), copy.deepcopy(answer)):
        assert type(other) is type(answer)
        assert says(other) == told
    assert says(answer) == told  # nothing was taken from the answer itself


@pytest.mark.slow
def test_answers_come_back_from_other_processes() -> None:
    scenes = ["fu2019", "delayed-spring"]
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        assert [*map(says, pool.map(hs.stability, scenes))] == [says(hs.stability(x)) for x in scenes]
        [found] = pool.map(hs.require, ["delayed-spring"], ["tau"])
    assert str(found) == str(hs.require("delayed-spring", "tau"))


def test_numbers_of_flint_come_back_with_all_of_their_digits() -> None:
    third = arb(1) / 3
    for x in (third, arb(-7), arb(0), third * arb(2) ** 900, arb(2, 0.5)):
        again = unpacked(packed(x))
        assert again.mid() == x.mid()
        assert x.rad() <= again.rad() <= x.rad() * arb("1.00000001")
    for x in (arb.pos_inf(), arb.neg_inf(), arb.nan(), arb(2, arb.pos_inf())):
        again = unpacked(packed(x))
        assert (again > 0, again < 0, again.is_nan()) == (x > 0, x < 0, x.is_nan())
        assert (str(again.mid()), str(again.rad())) == (str(x.mid()), str(x.rad()))
    with_terms = fmpq_mpoly_ctx.get(("x0", "x1"), Ordering.lex)
    x, y = with_terms.gens()
    for exact in (fmpq(2, 3), fmpq_poly([1, 0, 2]), fmpz_poly([3, 4]), x**2 / 3 - y, with_terms.constant(0)):
        again = unpacked(packed(exact))
        assert type(again) is type(exact)
        assert again == exact
    assert unpacked(packed(with_terms)) is with_terms
    matrix, row, z = arb_mat([[1, 2], [third, 4], [5, 6]]), arb_poly([1, third]), acb(third, -1)
    assert str(unpacked(packed(matrix))) == str(matrix)
    assert str(unpacked(packed(row))) == str(row)
    assert str(unpacked(packed(z))) == str(z)
