"""Code as text: how lines are broken, how routines are laid out in each language, and what is said of arguments."""

from __future__ import annotations

import re
from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest
from sympy import Integer, Rational, Symbol, cos, sin, symbols

import haptisym as hs
from haptisym.kernel.errors import SceneError
from haptisym.model.parameters import Rule
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.programs.program import Writer
from haptisym.writing.code.code import About, Argument, Source
from haptisym.writing.code.entry import FREQUENCY, _argument, scene_code, scene_program
from haptisym.writing.code.languages import Described, Routine, _documented, _filled, _statements, _wrapped, laid_out
from haptisym.writing.code.names import Language

a, b = symbols("a b", positive=True)


@pytest.mark.parametrize("indent", ["", "    "])
def test_a_line_of_code_is_broken_only_where_it_is_longer_than_a_hundred_columns(indent: str) -> None:
    for count in (95 - len(indent), 96 - len(indent), 97 - len(indent)):
        line = f"{indent}x = " + "y" * count
        assert _wrapped(line, indent) == [line]
    for filler, count in ((100, 1), (101, 2)):
        line = f"{indent}x = aa + " + "y" * (filler - len(indent) - 9)
        assert len(line) == filler
        assert len(_wrapped(line, indent)) == count
    words = " + ".join(f"name_{n}" for n in range(30))
    lines = _wrapped(f"{indent}x = {words}", indent, " ...")
    assert len(lines) > 2
    assert all(x.endswith(" ...") for x in lines[:-1])
    assert not lines[-1].endswith("...")
    assert " ".join(x.removesuffix(" ...").strip() for x in lines) == f"x = {words}"
    assert lines[0].startswith(f"{indent}x = ")
    assert all(x.startswith((f"{indent}    n", f"{indent}    +")) for x in lines[1:])
    assert all(len(x.removesuffix(" ...")) <= 100 for x in lines)
    for size in (96, 97):
        [*own] = _statements([("x", "y" * 10 + " + " + "z" * (size - 13))], "{} = {}", "", "({})")
        assert own[0].startswith("x = (") == (size > 96)
        assert own[-1].endswith(")") == (size > 96)


def test_names_are_documented_in_a_column_or_with_the_meaning_below() -> None:
    rows = [Described("a", "one"), Described("long", "two")]
    assert [*_documented(rows, "# ", "")] == ["# a     one", "# long  two"]
    assert [*_documented(rows, "  ", " : array")] == ["  a : array", "      one", "  long : array", "      two"]
    assert [*_documented([], "# ", "")] == []


def test_notes_of_a_header_are_filled_and_set_in_after_their_first_line_and_no_word_is_torn() -> None:
    pick = " ".join(f"well-known-{n}" for n in range(20))
    lines = _filled(pick, "# ")
    assert len(lines) > 2
    assert lines[0].startswith("# well")
    assert all(x.startswith("#   well") for x in lines[1:])
    assert " ".join(x.removeprefix("#").strip() for x in lines) == pick
    assert all(len(x) <= 100 for x in lines)
    assert [x.startswith("#  well") for x in _filled(pick, "# ", " ")[1:]] == [True] * (len(lines) - 1)


def routine(**own: Any) -> Routine:
    given: dict[str, Any] = {
        "name": "third", "heading": "A third.", "notes": ("Mind this.",), "arguments": (Described("k", "stiffness"), Described("unread", "not used")),
        "results": (Described("y", "a third"), Described("z", "more")), "definitions": (("t", "k/3.0"),), "values": (("y", "t"), ("z", "2.0*t")), "unused": ("unread",),
        "helpers": {}, "uses_pi": False,
    }  # fmt: skip
    return Routine(**(given | own))


@pytest.mark.parametrize("language", list(Language))
def test_a_routine_has_its_helpers_where_it_needs_them_and_its_words_in_every_language(language: Language) -> None:
    bare = laid_out(routine(), language)
    assert bare.endswith("\n")
    assert not bare.endswith("\n\n")
    for words in ("A third", "Mind this.", "stiffness", "a third"):
        assert words in bare
    for kind, told in (("sinc", "sin(x)/x, and 1 at x = 0"), ("sincm1", "by its series for small x")):
        shown = laid_out(routine(helpers={kind: f"third_{kind}"}), language)
        assert re.search(rf"third_{kind}\((double )?x\)", shown)
        assert told in shown
        assert told not in bare
    if language is Language.C:
        assert "const double pi = 3.141592653589793;" not in bare
        assert "const double pi = 3.141592653589793;" in laid_out(routine(uses_pi=True), language)
        assert bare.count("(void)") == bare.count("(void)unread;") == 1


def test_a_routine_in_numpy_computes_it() -> None:
    place: dict[str, Any] = {}
    helpers = {"sinc": "third_sinc", "sincm1": "third_sincm1"}
    exec(laid_out(routine(helpers=helpers, values=(("y", "t"), ("z", "third_sinc(k)"))), Language.NUMPY), place)  # noqa: S102  the text is of this test
    k = np.array([0.0, 1e-9, 0.5, 3.0, -2.0])
    found = place["third"](k, 1.0)
    assert found.y.tolist() == (k / 3).tolist()
    true = [1.0 if x == 0 else float((sin(x) / x).evalf(30)) for x in map(Rational, k)]
    assert found.z == pytest.approx(true, rel=1e-15)
    less = [0.0 if x == 0 else float((sin(x) / x - 1).evalf(30)) for x in map(Rational, k)]
    assert place["third_sincm1"](k) == pytest.approx(less, rel=1e-14)


# What is said of arguments


@pytest.mark.parametrize("language", [Language.C, Language.NUMPY])
def test_an_argument_says_what_it_is_in_which_unit_and_range_and_what_was_changed(language: Language) -> None:
    write = Writer((a, Symbol("lambda"), b))
    program = write.program({"y": write.expression(a * cos(Symbol("lambda")))})
    arguments = (
        Argument(a, "N/m", "stiffness", "> 0", "3 in the scene"),
        Argument(Symbol("lambda"), "", "", "", ""),
        Argument(b, "", "damping"),
    )
    text = " ".join(
        Source(program, arguments, About("T", ("note",), {"y": ("a force", "N")}))
        .code(language)
        .replace("*", " ")
        .replace("#", " ")
        .split()
    )
    assert "stiffness, N/m; > 0; 3 in the scene" in text
    assert ("called lambda in the formulas" in text) == (language is Language.NUMPY)
    assert "damping; no result depends on it" in text
    assert "a force, N" in text
    assert text.count("no result depends on it") == text.count("b damping; no result") + text.count(
        "b : array_like damping; no result"
    )
    bare = Source(program, arguments[:2]).code(language)
    assert "Values of closed forms." in bare
    assert "result" in bare
    for wrong, message in (
        ((arguments[0],), "the steps need lambda, which is no argument"),
        ((*arguments, arguments[0]), "a is an argument twice"),
    ):
        with pytest.raises(SceneError, match=message):
            Source(program, wrong).code(language)
    alone = Writer(())
    with pytest.raises(SceneError, match="at least one argument and one result"):
        Source(alone.program({"y": alone.expression(Integer(3))}), ()).code(language)


@pytest.mark.parametrize(
    ("own", "told"),
    [
        ({}, ("N/m", "stiffness k of the environment (spring)", "> 0", "2.5 in the scene")),
        ({"place": "rendered", "rule": Rule.NONNEGATIVE}, ("N/m", "stiffness k of what is rendered (spring)", ">= 0", "2.5 in the scene")),
        ({"place": "effects.filter", "rule": Rule.ANY}, ("N/m", "stiffness k of the effect filter (spring)", "any sign", "2.5 in the scene")),
        ({"place": "effects.spring", "rule": Rule.FRACTION}, ("N/m", "stiffness k of the effect spring", "between 0 and 1", "2.5 in the scene")),
        ({"dimension": Dimension.RATIO, "rule": Rule.ORDER}, ("", "number k of the environment (spring)", "", "2.5 in the scene")),
        ({"dimension": Dimension.ANY, "unit_in": lambda _: ""}, ("SI units", "number k of the environment (spring)", "> 0", "2.5 in the scene")),
        ({"value": Symbol("k")}, ("N/m", "stiffness k of the environment (spring)", "> 0", "")),
    ],
)  # fmt: skip
def test_a_parameter_of_a_scene_is_told_as_an_argument(own: dict[str, Any], told: tuple[str, ...]) -> None:
    given = {
        "symbol": Symbol("k"),
        "place": "environment",
        "key": "k",
        "model": "spring",
        "dimension": Dimension.STIFFNESS,
        "rule": Rule.POSITIVE,
        "value": Rational(5, 2),
        "unit_in": lambda _: "N/m",
    }
    knob: Any = Made(**(given | own))
    x = _argument(knob, MotionKind.TRANSLATION)
    assert (x.unit, x.meaning, x.range, x.example) == told
    assert x.symbol == Symbol("k")


def test_the_notes_of_a_scenes_code_tell_its_chain_its_fixed_values_and_where_it_comes_from() -> None:
    spring = hs.environments.mass_spring_damper(k=100, b=2)
    scene = hs.Scene(
        spring,
        (hs.effects.first_order_lag(20, name="motor"), hs.effects.shunt(b=1)),
        (0, 15),
        "0.1",
        title="Wall",
        source="a book",
    )
    text = " ".join(scene_code(scene, Language.JULIA, parameters=["omega_c"]).replace("#", " ").split())
    for words in (
        "H_env(s) = b s + k (mass-spring-damper)",
        "nearest the environment first: motor (first-order-lag), shunt.",
        "Source: a book",
        "Wall.",
    ):
        assert words in text
    fixed = re.search(r"Fixed values, SI: ([^.]*)\.", text)
    assert fixed
    assert sorted(x.split(" = ")[1] for x in fixed[1].split(", ")) == ["1", "100", "2"]
    assert "Rendered instead" not in text
    whole = " ".join(scene_code(hs.Scene(spring, (), (0, 15), "0.1"), Language.JULIA).replace("#", " ").split())
    assert "nearest the environment first: none." in whole
    assert "Fixed values" not in whole
    assert "Source:" not in whole
    assert "Distortion of a haptic display." in whole
    rendered = hs.Scene(spring, (), (0, 15), "0.1", rendered=hs.environments.mass_spring_damper(k=120))
    assert "Rendered instead: k" in scene_code(rendered, Language.C)
    assert [x.symbol.name for x in scene_program(scene, ["omega_c"]).arguments] == [
        "omega",
        next(p.symbol.name for p in scene.parameters if p.key == "omega_c"),
    ]
    assert scene_program(scene).arguments[0] == FREQUENCY
    assert len(scene_program(scene, ()).arguments) == 1
    with pytest.raises(SceneError, match="is a threshold, of which code holds nothing"):
        scene_program(scene, ["c"])
