"""The report page says what the evaluation proves, loads nothing, and its explorer draws what Python computes."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from html import unescape
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import browser
import numpy as np
import pytest
from browser import Browser
from explorers import typed
from marks import often, required
from pagereader import Page, equations, value
from reports import undrawn
from sympy import Rational, lambdify

import haptisym as hs
from haptisym.cli import main
from haptisym.kernel.symbols import s
from haptisym.pages import report as report_page
from haptisym.pages.report import page, save_report
from haptisym.writing.htmltext import Html, element, script
from haptisym.writing.names import named

E, F = hs.environments, hs.effects
SHIPPED = (
    "fu2019", "organ-tissue", "wave-variable-link", "undamped-resonance", "four-channel-teleoperation", "satellite-contact",
)  # fmt: skip
HOSTILE = "</title><script>alert(1)</script><!-- & \"quoted\" 'too' \x00\u202e"
OWN = {
    "hostile": hs.Scene(
        E.mass_spring_damper(1, 5, 100), (F.series("1/(1 + s/20)", name="</script><b>"),), title=HOSTILE, source=HOSTILE
    ),
    "tangency": hs.Scene(E.mass_spring_damper(k=1), (F.delay(1),), (0, 6), hs.Threshold.of("2", 5)),
    "two thresholds": hs.Scene(
        E.mass_spring_damper("0.01 kg*m^2", "0.2 N*m*s/rad", "3 N*m/rad"),
        (F.shunt(m="0.002 kg*m^2"), F.delay(0)), (3, 30), hs.Threshold.of("0.05", "0.2"),
    ),
    "no effects": hs.Scene(E.mass_spring_damper(1, 5, 100)),
    "unstable": hs.Scene(E.mass_spring_damper(1, 5, 100), (F.series("100/(s^2 - 0.1*s + 100)"),), (0, 30)),
    "many branches": hs.Scene(E.prony(100, [10 + i for i in range(12)], [1 + i for i in range(12)]), (F.first_order_lag(20),)),
    "algebraic threshold": hs.Scene(
        E.mass_spring_damper(1, 5, 100), (F.first_order_lag(20),), (0, 15), hs.Threshold.of(Rational(1, 2) ** Rational(1, 2))
    ),
}  # fmt: skip
EVERY = (*SHIPPED, *OWN)
CASES = often(EVERY, "fu2019".__eq__)


@cache
def evaluated(name: str) -> hs.Evaluation:
    return hs.evaluate(OWN[name] if name in OWN else hs.load_scene(name))


PAGES: list[Path] = []


@pytest.fixture(scope="session", autouse=True)
def _pages(tmp_path_factory: pytest.TempPathFactory) -> None:
    """A folder that all workers of a run share: a page takes seconds to write."""
    base = tmp_path_factory.getbasetemp()
    PAGES.append(base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base)


@cache
def written(name: str) -> str:
    """The page of a scene, written once in a run."""
    file = PAGES[-1] / f"report-{name.replace(' ', '-')}.html"
    if not file.exists():
        unfinished = file.with_suffix(f".{os.getpid()}")
        unfinished.write_text(page(evaluated(name)), encoding="utf-8")
        unfinished.replace(file)
    return file.read_text(encoding="utf-8")


@cache
def said(name: str) -> str:
    """The page of a scene but for its drawings."""
    return undrawn(evaluated(name))


def flat(document: object) -> Iterator[float]:
    """All numbers of a document."""
    if isinstance(document, dict):
        document = list(document.values())
    if isinstance(document, list):
        for entry in document:
            yield from flat(entry)
    elif isinstance(document, float):
        yield document


# The page as a document.


@pytest.mark.parametrize("name", CASES)
def test_the_page_is_well_formed_and_small(name: str) -> None:
    text = written(name)
    read = Page(text)
    assert len(text.encode()) < 1_500_000
    assert len(set(read.ids)) == len(read.ids)
    drawings = re.findall(r"<(?:math|svg)\b.*?</(?:math|svg)>", text, re.DOTALL)
    assert len(drawings) > 15
    for drawing in drawings:
        ElementTree.fromstring(drawing)
    for used in re.findall(
        r'(?:xlink:href="#|url\(#)([^")]+)', re.sub("<script.*?</script>", "", text, flags=re.DOTALL)
    ):
        assert used in read.ids


@pytest.mark.parametrize("name", CASES)
def test_the_page_refers_to_nothing_outside_of_itself(name: str) -> None:
    read = Page(written(name))
    assert read.loads == []
    assert not {"link", "img", "iframe", "object", "embed", "base"} & set(read.tags)
    assert "default-src 'none'" in unescape(written(name))


@pytest.mark.parametrize("name", CASES)
def test_every_number_of_the_page_is_one_of_the_document(name: str) -> None:
    result, text = evaluated(name), written(name)
    steps = re.sub(r'<section id="which-values-would-do">.*?</section>', "", text, flags=re.DOTALL)
    document, read = result.to_dict(), Page(steps)
    [held] = re.findall(r'<script type="application/json" id="evaluation">(.*?)</script>', text, re.DOTALL)
    assert json.loads(held) == document
    told = [*document["transparent"], *[p["band"] for p in document["percepts"]], *document["outside_model"]]
    told += [document["changeovers"], document["unbounded"], [c["omega"] for c in document["crossings"]]]
    passivity = result.passivity  # a question of its own, whose answer the page repeats
    most = [x for x in (passivity.damping, passivity.most_given) if x] if passivity.is_active else []
    active = {*flat(passivity.row()), *(float(x) for one in most for x in (one.value, one.omega) if x is not None)}
    assert set(flat(told)) <= set(read.numbers) <= {*flat(document), *active, *(-x for x in active)}
    shown = "".join(read.texts)
    for c in document["crossings"]:
        assert c["digits"] in shown
        assert all(end in shown for end in c["enclosure"])


@pytest.mark.slow
def test_hostile_text_stays_text() -> None:
    text = written("hostile")
    read = Page(text)
    assert read.tags.count("script") == 4  # the code, the explorer, its data and the evaluation
    assert "b" not in read.tags
    visible = HOSTILE.replace("\x00", "\ufffd")
    assert [x for x in read.texts if x == visible]


def test_text_is_escaped_by_construction() -> None:
    assert element("p", "<b>", given={"title": '"<'}) == '<p title="&quot;&lt;">&lt;b&gt;</p>'
    assert element("p", Html("<b></b>")) == "<p><b></b></p>"
    assert element("p", "a\x00\ud800\uffffb") == "<p>a\ufffd\ufffd\ufffdb</p>"
    assert Page(script("x = '</script>'; // <!--")).tags == ["script"]


@pytest.mark.parametrize("name", CASES)
def test_every_control_has_a_name(name: str) -> None:
    read = Page(written(name))
    inputs = [x for x in read.controls if x["type"] in ("range", "number")]
    assert len(inputs) == 2 * len(read.labels) >= 4
    assert all(x["aria-label"] for x in inputs)
    assert set(read.labels) <= set(read.ids)


# What it says.


def response(scene: hs.Scene, omega: float) -> tuple[complex, complex]:
    """H_env and H_perc at a frequency, by complex numbers and the effects one by one."""

    def at(form: Any) -> complex:
        return complex(lambdify(s, form, "mpmath")(1j * omega))

    H = at((scene.rendered or scene.environment).H)
    for effect in scene.effects:
        a, b, c, d = map(at, effect.matrix)
        H = (a * H + b) / (c * H + d)
    return at(scene.environment.H), H


def spelt(symbol: str) -> str:
    """A symbol's name as the reader spells it."""
    name = named(symbol)
    below = "".join(word.letters.replace(" ", "_") for word in name.below)
    return f"{name.head.letters}_{below}" if below else name.head.letters


NAMED = {
    "H_envs": lambda env, perc, w: env,
    "H_percs": lambda env, perc, w: perc,
    "ReDeltaHomegaj": lambda env, perc, w: (perc - env).real,
    "ImDeltaHomegaj": lambda env, perc, w: (perc - env).imag,
    "|H_envomegaj|2": lambda env, perc, w: abs(env) ** 2,
    "r_romega": lambda env, perc, w: abs((perc - env).real) / abs(env),
    "r_iomega": lambda env, perc, w: abs((perc - env).imag) / abs(env),
    "ReDeltaHomegaj/H_envomegaj": lambda env, perc, w: ((perc - env) / env).real,
    "ImDeltaHomegaj/H_envomegaj": lambda env, perc, w: ((perc - env) / env).imag,
    "k_percomega": lambda env, perc, w: perc.real,
    "m_percomega": lambda env, perc, w: -perc.real / w**2,
    "b_percomega": lambda env, perc, w: perc.imag / w,
}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", [x for x in CASES if x != "hostile"])
@pytest.mark.parametrize("omega", [4.5, 11.25])
def test_every_formula_of_the_page_has_the_value_that_the_physics_has(name: str, omega: float) -> None:
    """Long formulas are broken in lines and named in parts: read together again, nothing is lost and no sign is turned."""
    # without dimensions names have other meanings, and leading terms are no values
    page_of_values = re.split(r"<h3>(?:Without dimensions|Fast devices)", said(name))[0]
    scene, listed = evaluated(name).scene, equations(page_of_values)
    known: dict[str, complex] = {spelt(p.symbol.name): float(p.value) for p in scene.parameters}
    known |= {"s": 1j * omega, "omega": omega}
    for left, sides in [x for x in listed if re.fullmatch(r"[ND]_\d+", x[0])]:
        known[left] = value(sides[-1][1], known) if "N_" not in sides[-1][1] else math.nan
    env, perc = response(scene, omega)
    size, checked = {True: abs(env) + abs(perc), False: 1.0}, set()
    for left, sides in listed:
        relation, side = sides[-1]
        if re.fullmatch(r"[A-Z](?:_\w+)?|x_\d+", left) and left not in NAMED:
            known[left] = value(side, known)  # a named step
        elif left in NAMED and not ("Delta" in side or "H_perc" in side):
            expected = NAMED[left](env, perc, omega)
            scale = size[left.startswith(("H", "Re", "Im")) and "/" not in left] if left[0] != "|" else abs(env) ** 2
            assert value(side, known) == pytest.approx(
                expected, rel=2e-4 if relation == "≈" else 1e-9, abs=1e-6 * scale
            ), left
            checked.add(left)
    assert {"H_envs", "ReDeltaHomegaj", "ImDeltaHomegaj", "|H_envomegaj|2"} <= checked


@pytest.mark.parametrize("name", often(SHIPPED, "fu2019".__eq__))
def test_the_threshold_functions_are_positive_exactly_where_a_ratio_exceeds(name: str) -> None:
    scene = evaluated(name).scene
    forms = {left: sides[-1][1] for left, sides in equations(said(name)) if left in ("p_romega", "p_iomega")}
    low, high = (float(x) for x in scene.band)
    for omega in np.linspace(low, high, 14)[1:-1]:
        env, perc = response(scene, omega)
        for left, part in (("p_romega", (perc - env).real), ("p_iomega", (perc - env).imag)):
            excess = abs(part) / abs(env) - 0.1
            if abs(excess) > 1e-3:
                assert (value(forms[left], {"omega": omega}).real > 0) == (excess > 0), (left, omega)


def test_what_is_undecided_is_said() -> None:
    """A tangency that stayed open, made from one that did not."""
    result = evaluated("tangency")
    points = [
        replace(x, undecided=frozenset(result.criteria[:1])) if x.orders.get(result.criteria[0]) else x
        for x in result.chart.points
    ]
    opened = replace(result, chart=replace(result.chart, points=tuple(points)))
    [(_, point)] = opened.undecided
    shown = " ".join(Page(undrawn(opened)).texts)
    assert not opened.certified
    assert "in part undecided" in shown
    assert "1 tangency stayed open" in shown
    assert "UNDECIDED" in shown
    assert all(end in shown for end in point.omega.enclosure(15))
    assert "undecided" not in " ".join(Page(said("tangency")).texts)


@pytest.mark.slow
def test_stability_is_said_as_it_is() -> None:
    loop = hs.Scene(E.kelvin_voigt(100, 1), (F.zero_order_hold("10 ms"), F.compliance(k=300)))
    assert "not decided" in " ".join(Page(undrawn(hs.evaluate(loop))).texts)
    assert "NOT stable" in " ".join(Page(said("unstable")).texts)
    assert "all poles of" in " ".join(Page(said("fu2019")).texts)


@pytest.mark.slow
def test_a_scene_with_too_many_parameters_keeps_the_threshold_slider() -> None:
    assert len(Page(said("many branches")).labels) == 2
    assert "too many" in said("many branches")


@pytest.mark.slow
def test_two_thresholds_have_a_slider_each() -> None:
    labels = Page(said("two thresholds")).labels
    assert {"explorer-c-real", "explorer-c-imag"} <= set(labels)
    assert "explorer-c" in Page(said("fu2019")).labels


# Files.


@pytest.mark.slow
def test_the_command_writes_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    target = tmp_path / "x.html"
    status, _, err = command(monkeypatch, capsys, "--json", "--report", str(target))
    assert (status, err) == (0, f"report written to {target}\n")
    assert target.read_text(encoding="utf-8") == written("fu2019")


@pytest.mark.slow
def test_the_command_writes_a_pdf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    required("pdflatex", shutil.which("pdflatex"))
    target = tmp_path / "x.PDF"
    status, _, _ = command(monkeypatch, capsys, "--report", str(target))
    assert status == 0
    assert target.read_bytes().startswith(b"%PDF")
    assert len(target.read_bytes()) > 50_000


@pytest.mark.slow
def test_the_same_evaluation_gives_the_same_pdf_of_the_day_that_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """SOURCE_DATE_EPOCH is the day of reproducible builds: 1551398400 s are the first of March 2019."""
    required("pdflatex", shutil.which("pdflatex"))
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1551398400")
    first, second = (report_page.pdf(evaluated("fu2019").document()) for _ in range(2))
    assert first == second
    assert b"D:20190301" in first


@pytest.mark.slow
def test_the_pdf_shows_all_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    required("pdflatex", shutil.which("pdflatex"))
    seen: list[tuple[str, set[str]]] = []

    def kept(program: str, folder: str) -> None:
        seen.append(
            ((Path(folder) / "report.tex").read_text(encoding="ascii"), {x.name for x in Path(folder).glob("*.pdf")})
        )
        run(program, folder)

    run = report_page._run
    monkeypatch.setattr(report_page, "_run", kept)
    save_report(evaluated("fu2019"), tmp_path / "x.pdf")
    text, files = seen[0]
    assert len(files) == 5
    assert all(f"{{{name}}}" in text for name in files)


def test_other_names_and_a_missing_program_are_errors_that_say_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    status, out, err = command(monkeypatch, capsys, "--report", str(tmp_path / "x.docx"))
    assert (status, out, err) == (2, "", 'error: report: the name "x.docx" must end in .html or .pdf\n')
    monkeypatch.setenv("PATH", str(tmp_path))
    status, _, err = command(monkeypatch, capsys, "--report", str(tmp_path / "x.pdf"))
    assert status == 2
    assert "needs pdflatex" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_document_that_latex_refuses_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    required("pdflatex", shutil.which("pdflatex"))
    monkeypatch.setattr(
        "haptisym.pages.report.latex", lambda *_: r"\documentclass{article}\begin{document}\no\end{document}"
    )
    with pytest.raises(hs.SceneError, match="could not set the document: ! Undefined control sequence"):
        save_report(evaluated("fu2019"), tmp_path / "x.pdf")


def command(monkeypatch: pytest.MonkeyPatch, capsys: Any, *options: str) -> tuple[int, str, str]:
    monkeypatch.setattr("sys.argv", ["haptisym", "evaluate", "fu2019", *options])
    with pytest.raises(SystemExit) as stop:
        main()
    out, err = capsys.readouterr()
    return int(stop.value.code or 0), out, err


# In a browser.


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Opens a page in Chromium by its name."""
    required("chromium", browser.program())
    folder = tmp_path_factory.mktemp("pages")
    with browser.running() as opened:

        def show(name: str, *, whole: bool = False) -> Browser:
            file = folder / f"{name.replace(' ', '-')}.html"
            file.write_text((written if whole else said)(name), encoding="utf-8")
            opened.look(1280)
            opened.open(file)
            return opened

        yield show


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_the_page_loads_without_a_complaint_and_asks_for_nothing(name: str, shown: Any) -> None:
    opened = shown(name, whole=True)
    assert opened.complaints() == []
    assert len(opened.requests()) == 1
    assert opened.value("document.querySelectorAll('#explorer-panel path.ratio').length") == 2
    assert opened.value("document.title") == (evaluated(name).scene.title or "Untitled scene").replace("\x00", "\ufffd")


def drawn(opened: Browser, kind: str) -> np.ndarray:
    """The points of a curve of the explorer, in the data's own coordinates."""
    d = opened.value(f"document.querySelector('#explorer-panel path.{kind}').getAttribute('d')")
    return np.array([[float(x) for x in point.split()] for point in re.split("[ML]", d)[1:]])


def slider(scene: hs.Scene, name: str) -> str:
    return f"explorer-{[p.symbol.name for p in scene.parameters].index(name)}"


MOVED = {
    "fu2019": {"omega_n": 47.5, "zeta": 0.7, "m": 2.5},
    "wave-variable-link": {"tau": 0.035, "k": 210.0},
    "organ-tissue": {"alpha": 0.31, "tau": 0.004},
    "undamped-resonance": {"zeta": 0.35},
    "four-channel-teleoperation": {"Ks": 55.0, "tau": 0.03},
    "two thresholds": {"b": 0.45, "tau": 0.05},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", often(MOVED, "fu2019".__eq__))
def test_a_moved_slider_draws_what_python_computes(name: str, shown: Any) -> None:
    opened, scene = shown(name), evaluated(name).scene
    before = {kind: drawn(opened, kind) for kind in ("ratio.real", "system.perceived")}
    for parameter, number in MOVED[name].items():
        typed(opened, slider(scene, parameter), number)
    f = scene.symbolic_distortion().compile()
    given = {p.symbol.name: float(p.value) for p in scene.parameters} | MOVED[name]
    low, high = (float(x) for x in scene.band)
    real, imag = drawn(opened, "ratio.real"), drawn(opened, "ratio.imag")
    omega = real[:, 0]
    assert (omega[0], omega[-1]) == (low, pytest.approx(high, rel=1e-15))
    assert (np.diff(omega) > 0).all()
    assert len(omega) > 250
    used = {x.name for x in scene.symbolic_distortion().free_symbols}
    computed = f(omega, **{key: number for key, number in given.items() if key in used})
    inside = np.isfinite(computed.ratio_real) & (computed.ratio_real < 5)
    assert real[inside, 1] == pytest.approx(computed.ratio_real[inside], rel=1e-9, abs=1e-9)
    assert imag[inside, 1] == pytest.approx(computed.ratio_imag[inside], rel=1e-9, abs=1e-9)
    size = np.abs(computed.environment_real).max() + np.abs(computed.environment_imag).max()
    for system in ("environment", "perceived"):
        points = drawn(opened, f"system.{system}")
        for column, part in enumerate(("real", "imag")):
            assert points[:, column] == pytest.approx(getattr(computed, f"{system}_{part}"), rel=1e-9, abs=1e-9 * size)
    for kind, points in before.items():
        assert drawn(opened, kind).shape != points.shape or not np.allclose(drawn(opened, kind), points)


def bands(opened: Browser) -> list[list[float]]:
    script = "[...document.querySelectorAll('#explorer-ratios rect.band')].map(x => [+x.getAttribute('x'), +x.getAttribute('width')])"
    return [[low, low + width] for low, width in opened.value(script)]


@pytest.mark.slow
@pytest.mark.parametrize("name", often(SHIPPED, "fu2019".__eq__))
def test_at_the_scenes_values_the_explorer_draws_the_proven_bands(name: str, shown: Any) -> None:
    proven = [x for x in evaluated(name).to_dict()["transparent"] if x[0] < x[1]]
    assert bands(shown(name)) == [pytest.approx(x, rel=1e-9, abs=1e-9) for x in proven]


@pytest.mark.slow
def test_the_bands_of_other_values_are_those_of_a_scene_with_these_values(shown: Any) -> None:
    opened = shown("fu2019")
    typed(opened, "explorer-3", 47.5)
    typed(opened, "explorer-c", 0.15)
    other = hs.Scene(E.mass_spring_damper("1.8", 15, 100), (F.second_order_lowpass("47.5", "0.5"),), threshold="0.15")
    result = hs.evaluate(other).to_dict()
    assert bands(opened) == [pytest.approx(x, rel=1e-9) for x in result["transparent"]]
    told = opened.value("document.getElementById('explorer-crossings').textContent")
    assert [f"{c['omega']:.4g}" for c in result["crossings"]] == re.findall(r"at ([\d.]+\d)", told)


@pytest.mark.slow
def test_the_sliders_work_by_keyboard_and_the_button_puts_them_back(shown: Any) -> None:
    opened = shown("fu2019")
    number, before = "+document.getElementById('explorer-3-value').value", drawn(opened, "ratio.real")
    opened.value("document.getElementById('explorer-3').focus()")
    for _ in range(3):
        opened.press("ArrowRight", 39)
    assert opened.value(number) == pytest.approx(80 * 10 ** (3 / 500), rel=1e-3)
    assert opened.value("document.getElementById('explorer-3').getAttribute('aria-valuetext')") == "81.11 rad/s"
    moved = drawn(opened, "ratio.real")
    opened.press("ArrowLeft", 37)
    opened.press("ArrowRight", 39)
    assert np.array_equal(drawn(opened, "ratio.real"), moved)
    assert np.array_equal(drawn(opened, "ghost.real"), before)  # the scene's own curve stays
    opened.value("document.getElementById('explorer-reset').focus()")
    opened.press("Enter", 13, "\r")
    assert opened.value(number) == 80
    assert np.array_equal(drawn(opened, "ratio.real"), before)
    assert not opened.value("document.querySelectorAll('#explorer-panel .ghost').length")


@pytest.mark.slow
@pytest.mark.parametrize("number", [-3.0, 0.0])
def test_a_value_that_the_model_does_not_allow_is_marked_and_not_drawn(number: float, shown: Any) -> None:
    opened = shown("fu2019")
    before = drawn(opened, "ratio.real")
    typed(opened, "explorer-3", number)
    assert opened.value("document.getElementById('explorer-3-value').getAttribute('aria-invalid')") == "true"
    assert np.array_equal(drawn(opened, "ratio.real"), before)


@pytest.mark.slow
def test_a_delay_of_zero_may_be_typed(shown: Any) -> None:
    """It is a limit of the model, allowed, though a slider of decades does not reach it."""
    opened, scene = shown("organ-tissue"), evaluated("organ-tissue").scene
    typed(opened, slider(scene, "tau"), 0.0)
    points = drawn(opened, "ratio.imag")
    given = {p.symbol.name: float(p.value) for p in scene.parameters} | {"tau": 0.0}
    assert points[:, 1] == pytest.approx(
        scene.symbolic_distortion().compile()(points[:, 0], **given).ratio_imag, abs=1e-9
    )
    assert opened.complaints() == []


@pytest.mark.slow
def test_the_page_fits_a_telephone_and_has_a_dark_side(shown: Any) -> None:
    opened = shown("wave-variable-link", whole=True)
    for width in (1280, 400, 320):
        opened.look(width)
        assert opened.value("document.documentElement.scrollWidth") <= width
    colour = "getComputedStyle(document.body).backgroundColor"
    assert opened.value(colour) == "rgb(255, 255, 255)"
    opened.look(1280, dark=True)
    assert opened.value(colour) == "rgb(21, 24, 28)"


@pytest.mark.slow
def test_the_printed_page_leaves_the_explorer_out(shown: Any) -> None:
    opened = shown("fu2019")
    opened.call("Emulation.setEmulatedMedia", media="print")
    try:
        assert opened.value("document.getElementById('explorer').offsetHeight") == 0
        assert opened.value("document.getElementById('derivation').offsetHeight") > 500
        assert opened.printed().startswith(b"%PDF")
    finally:
        opened.call("Emulation.setEmulatedMedia", media="")


@pytest.mark.slow
def test_the_page_says_which_values_of_each_parameter_would_do() -> None:
    """The paper's example: a filter from 122.36 rad/s on, and no mass, damping or stiffness at all."""
    shown = " ".join(Page(said("fu2019")).texts)
    assert "Which values would do?" in shown
    assert shown.count("no value") == 3
    for end in ("ω n ≥ 122.36 rad/s", "0 ≤ ζ ≤ 0.26435", "c ≥ 0.15542"):
        assert end in " ".join(shown.split())
    assert "Which values would do?" not in " ".join(Page(said("tangency")).texts)
