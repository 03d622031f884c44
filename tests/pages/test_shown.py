"""What a session shows: a short line for every value, the command line's page where an answer is printed, the same in a notebook."""

from __future__ import annotations

import copy
import importlib
import pickle
import pkgutil
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from html import unescape
from typing import Any

import pytest
from marks import often
from pagereader import Page
from sympy import Basic

import haptisym as hs
from haptisym.judge.answers import Answer
from haptisym.kernel.reals import RealNumber

PAPER = hs.load_scene("fu2019")
MOST = 200
"""Characters of one value's line."""

ANSWERS: dict[str, Callable[[], Any]] = {
    "evaluate fu2019": lambda: hs.evaluate("fu2019"),
    "evaluate delayed-spring": lambda: hs.evaluate("delayed-spring"),
    "require fu2019 --free omega_n": lambda: hs.require("fu2019", "omega_n"),
    "require delayed-spring --free tau": lambda: hs.require("delayed-spring", "tau"),
    "require fu2019 --free zeta --range 0.4 0.6 --free omega_n --range 50 500 --slices 3": lambda: hs.design_map(
        "fu2019", ["zeta", "omega_n"], [("0.4", "0.6"), (50, 500)], slices=3
    ),
    "sensitivity fu2019": lambda: hs.sensitivity("fu2019"),
    "tolerances fu2019-tolerances --samples 3": lambda: hs.tolerances("fu2019-tolerances", samples=3),
    "effects fu2019 --tolerance 0.01": lambda: hs.relevance("fu2019", "0.01"),
    "metrics fu2019": lambda: hs.metrics("fu2019"),
    "metrics sidestick": lambda: hs.metrics("sidestick"),
    "derive fu2019": lambda: hs.derive("fu2019"),
    "evaluate palpation-device": lambda: hs.evaluate_all(hs.load_scenes("palpation-device")),
}


@pytest.fixture(scope="module", params=often(ANSWERS, lambda words: not words.startswith("tolerances")))
def answer(request: pytest.FixtureRequest) -> tuple[str, Any]:
    """A command line, and the answer of the same verb in Python."""
    return request.param, ANSWERS[request.param]()


@pytest.mark.few(2)
def test_print_shows_the_command_lines_page(answer: tuple[str, Any], call: Callable[..., tuple[int, str, str]]) -> None:
    words, found = answer
    status, out, _ = call(*words.split())
    assert status == 0
    assert str(found) == out


def test_an_answer_is_one_short_line_that_says_its_kind_and_its_scene(answer: tuple[str, Any]) -> None:
    line = repr(answer[1])
    assert re.fullmatch(rf'<{type(answer[1]).__name__} "[^"\n]+": [^\n]+>', line), line
    assert len(line) <= MOST


def test_a_notebook_shows_an_answer_as_its_page_or_better(answer: tuple[str, Any]) -> None:
    _, found = answer
    assert isinstance(found, Answer)
    html = found._repr_html_()
    read = Page(html)  # well formed, or it raises
    assert read.tags
    if html.startswith("<pre"):
        assert unescape(re.fullmatch(r'<pre class="haptisym">([^<>]*)</pre>', html)[1]) == str(found)  # type: ignore[index]


@pytest.mark.few(3)
def test_every_answer_has_its_document(answer: tuple[str, Any]) -> None:
    _, found = answer
    assert found.to_dict()["schema"].startswith("haptisym.")
    assert found.to_json().startswith("{")


def parts(value: Any, depth: int = 4) -> Iterator[Any]:
    """A value, and what a session can reach in it by its public names."""
    yield value
    if depth == 0 or isinstance(value, Basic | str | int | float | RealNumber) or kernel(value):
        return
    if isinstance(value, Mapping):
        inner = list(value.values())[:3]
    elif isinstance(value, tuple | list):
        inner = list(value)[:3]
    elif is_dataclass(value):
        names = [f.name for f in fields(value)] + [n for n, x in vars(type(value)).items() if isinstance(x, property)]
        inner = [getattr(value, name) for name in names if not name.startswith("_")]
    else:
        return
    for x in inner:
        yield from parts(x, depth - 1)


def kernel(value: Any) -> bool:
    """Whether a value is a function of the exact or the numeric kernel, which nobody asks for in a session."""
    module = type(value).__module__
    return module.startswith(("haptisym.kernel.", "haptisym.programs.")) and not isinstance(
        value, hs.Point | hs.Interval
    )


def ours(value: Any) -> bool:
    """Whether a value is of this package and holds no formula of the user's length."""
    if isinstance(value, RealNumber):
        return True
    return (
        type(value).__module__.startswith("haptisym")
        and not kernel(value)
        and not any(
            isinstance(x, Basic) and len(str(x)) > 40
            for x in (vars(value).values() if hasattr(value, "__dict__") else ())
        )
    )


@pytest.mark.few(3)
def test_everything_that_can_be_reached_in_an_answer_is_shown_in_a_few_characters(answer: tuple[str, Any]) -> None:
    seen = set()
    for x in parts(answer[1]):
        if ours(x) and id(x) not in seen:
            seen.add(id(x))
            assert len(repr(x)) <= 2 * MOST, (type(x).__name__, len(repr(x)), repr(x)[:300])
            assert "object at 0x" not in repr(x), repr(x)
    assert len(seen) > 5


def kinds(base: type) -> Iterator[type]:
    yield base
    for kind in base.__subclasses__():
        yield from kinds(kind)


def test_every_kind_of_number_shows_its_digits() -> None:
    for kind in kinds(RealNumber):
        if kind.__module__.startswith("haptisym"):
            own = next(x for x in kind.__mro__ if "__repr__" in vars(x))
            assert own.__module__ == "haptisym.kernel.reals", kind


@pytest.mark.parametrize(
    ("value", "line"),
    [
        (lambda: hs.evaluate(PAPER).bandwidth, "7.97891679017471"),
        (lambda: hs.evaluate(PAPER).crossings[0], "<Crossing r_r exceeds its threshold at 7.97891679017471 rad/s>"),
        (lambda: hs.evaluate(PAPER).percepts[0], "<Percept lower mass (real part) from 7.9789 to 15.000 rad/s>"),
        (lambda: hs.evaluate(PAPER).transparent[0], "<Interval from 0 to 7.97891679017471 rad/s>"),
        (lambda: hs.evaluate(PAPER).changeovers_environment[0], "<Point at 7.45355992499930 rad/s>"),
        (lambda: hs.peaks(PAPER), '<Peaks "Numerical example of Fu, van Paassen and ...": 1 peak>'),
        (lambda: hs.peaks(PAPER)[0], "<Peak r_i = 0.0387709 at 4.35101 rad/s>"),
        (lambda: PAPER.environment, "<Environment mass-spring-damper: m = 9/5 kg; b = 15 N*s/m; k = 100 N/m>"),
        (lambda: PAPER.effects[0], "<Effect filter (second-order-lowpass): omega_n = 80 rad/s; zeta = 1/2>"),
        (lambda: hs.effects.delay("5 ms"), "<Effect delay: tau = 1/200 s>"),
        (lambda: hs.effects.first_order_lag(hs.symbols("omega_c")), "<Effect first-order-lag: omega_c>"),
        (
            lambda: hs.environments.mass_spring_damper(m="1.8 kg +- 5 %").parameters[0],
            "<Parameter m = 9/5 kg, from 171/100 to 189/100 kg>",
        ),
        (lambda: hs.environments.expression("2*s + 1"), "<Environment expression: 2*s + 1>"),
        (lambda: hs.effects.shunt(m=1), "<Effect shunt: m = 1 kg>"),
        (lambda: hs.require(PAPER, "omega_n").feasible, "(<Span from 122.356 on>,)"),
        (lambda: hs.derive(PAPER).changeovers("env"), "(<Solution omega = sqrt(k)/sqrt(m)>,)"),
        (lambda: hs.Threshold.of("0.1"), "Threshold(real=1/10, imag=1/10)"),
        (
            lambda: hs.evaluate(PAPER),
            '<Evaluation "Numerical example of Fu, van Paassen and ...": bandwidth 7.9789 rad/s, 2 crossings, 2 percepts>',
        ),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_values_are_shown_as_a_person_would_write_them(value: Callable[[], Any], line: str) -> None:
    assert repr(value()) == line


def test_hostile_titles_stay_text_in_a_notebook_and_on_one_line() -> None:
    scene = hs.Scene(PAPER.environment, PAPER.effects, title="<script>&\nalert")
    assert "\n" not in repr(scene)
    html = hs.sensitivity(scene)._repr_html_()
    assert "<script>" not in html
    assert "&lt;script&gt;&amp;" in html


def test_every_kind_of_answer_names_a_page_that_is_there() -> None:
    for module in pkgutil.walk_packages(hs.__path__, "haptisym."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    found = [kind for kind in kinds(Answer) if kind is not Answer]
    assert len(found) > 10
    for kind in found:
        assert callable(pkgutil.resolve_name(kind._page)), kind
        assert re.fullmatch(r"haptisym\.\w+/\d", kind._schema), kind


@pytest.mark.slow
def test_answers_are_found_without_what_writes_them() -> None:
    script = """
import sys
import haptisym as hs
hs.evaluate("fu2019", tolerance="1 %").to_json()
hs.metrics("fu2019")
print(*sorted(x for x in sys.modules if x.startswith("haptisym.")))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert not [x for x in loaded if x.split(".")[1] in ("pages", "figures", "commands")]


def test_what_was_evaluated_can_be_pickled_and_copied_and_answers_the_same() -> None:
    scene = hs.load_scene("fu2019")
    found = hs.evaluate(scene, 20, tolerance="1 %")
    for value in (scene, hs.load_scenes("palpation-device")):
        assert pickle.loads(pickle.dumps(value)) == value
        assert copy.deepcopy(value) == value
    for answer in (found, found.relevance, hs.peaks(scene), hs.evaluate("delayed-spring")):
        again = pickle.loads(pickle.dumps(answer))
        assert type(again) is type(answer)
        assert again.to_json() == answer.to_json()  # type: ignore[union-attr]
        assert copy.copy(answer).to_json() == answer.to_json()  # type: ignore[union-attr]


def test_peaks_are_an_answer_and_a_tuple() -> None:
    found = hs.peaks("steering-wheel")
    document = found.to_dict()
    assert found.certified
    assert found == tuple(found)
    assert [row["omega"] for row in document["peaks"]] == [float(x.omega) for x in found]
    assert [row["part"] for row in document["peaks"]] == ["imag", "real"]
    assert document["certified"] is True
    for x in found:
        assert x.omega.digits() in str(found)
    assert "No ratio has a local maximum" in str(hs.peaks(hs.Scene(PAPER.environment)))
