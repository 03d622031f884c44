"""Generated code, run in its own language, has the values of the physics; it says what it is given, and has nothing else.

The witness is the scene's own equations, H_env(s) and the chain matrices, multiplied out with 60 digits of mpmath at
s = j omega: no closed form, no real or imaginary part of one, no simplification is shared with the code under test.
"""

from __future__ import annotations

import json
import keyword
import random
import re
import shutil
import subprocess
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import inf, nextafter
from pathlib import Path

import mpmath
import numpy as np
import pytest
from formulas import EXPRESSIONS
from hypothesis import assume, given
from marks import WRITTEN_OUT, examples, often, required
from sympy import Abs, Expr, I, Integer, Rational, Symbol, cosh, exp, pi, sinh, sqrt, symbols

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.errors import SceneError
from haptisym.programs.program import Writer
from haptisym.programs.steps import page_steps
from haptisym.programs.values import Values
from haptisym.writing.code import (
    DIALECTS,
    RESERVED,
    Argument,
    CodeReader,
    Language,
    Source,
    closed,
    comment,
    distortion_code,
    function_name,
    identifiers,
    nearest_double,
    scene_code,
    scene_program,
)

MP = mpmath.mp.clone()


MP.dps = 60


FIELDS = Values._fields


TOLERANCE = 1e-12


DUST = MP.mpf(10) ** -39  # what is left at 10^-400 rad/s of a power omega^0.1 whose limit is 0


AWKWARD = ["lambda", "end", "int", "function", "yield", "i", "e", "cos", "values", "distortion", "x1", "W", "_a", "µ"]


HOSTILE = 'Ends /* comments */ and """strings""", %} #} ?? / \\ $(x) \\u{1} \u2028import os\n"; \x1b[0m'


def awkward_scene() -> hs.Scene:
    formula = "lambda*s^2 + end*s*i + int*e + function*values/(yield + s*cos) + distortion*s + x1*W + _a + µ*s"
    given = {name: str(n) for n, name in enumerate(AWKWARD, 2)}
    return hs.Scene(
        environments.expression(formula, parameters=given), (effects.delay("3 ms"),), title=HOSTILE, source=HOSTILE
    )


MSD = environments.mass_spring_damper("1.2 kg", "8 N*s/m", "150 N/m")


OTHERS = {
    "names that languages have": awkward_scene(),
    "maxwell": hs.Scene(environments.maxwell(90, 4), (effects.first_order_lag("12 Hz"), effects.compliance(k=2000, b=3))),
    "prony": hs.Scene(environments.prony(200, [100, 300], [5, 1]), (effects.pade_delay("4 ms", 3), effects.shunt(m="-45 g"))),
    "two ports": hs.Scene(MSD, (effects.two_port("1", "2*s^2", "1/(k + s)", "1", parameters={"k": 900}), effects.series("1/(1 + s*T)^2", parameters={"T": "2 ms"}))),
    "position-position": hs.Scene(MSD, (effects.position_position_teleoperator(1, 20, 400, 2, 30, 500, "10 ms"),)),
    "spring-pot alone, whole numbers only": hs.Scene(environments.spring_pot(80, "1/2"), (effects.first_order_lag(20),)),
    "spring-pots in a row": hs.Scene(environments.spring_pot(80, "0.3", 100), (effects.series(10 / (10 + hs.s ** Rational(3, 4))), effects.coulomb_friction("0.2 N", "5 cm"))),
    "hold alone": hs.Scene(environments.mass_spring_damper(k=150), (effects.zero_order_hold("1 ms"),)),
    "no effect": hs.Scene(MSD),
}  # fmt: skip


NAMES = list(WRITTEN_OUT)


SCENES = {**{name: hs.load_scene(name) for name in NAMES}, **OTHERS}


def fourier(pieces):
    """Both parts of the first harmonic, in phase and a quarter turn ahead, of what answers sin(theta).

    From each angle of half a period to the next it is a + b sin(theta); the other half is its negative.
    """
    in_phase = ahead = MP.mpf(0)
    for start, end, a, b in pieces:
        for t, sign in ((end, 1), (start, -1)):  # the integrals of a sin + b sin^2 and of a cos + b sin cos
            in_phase += sign * (b * (2 * t - MP.sin(2 * t)) / 4 - a * MP.cos(t))
            ahead += sign * (a * MP.sin(t) + b * MP.sin(t) ** 2 / 2)
    return 2 * in_phase / MP.pi, 2 * ahead / MP.pi


def limited(u):
    """What follows the sine up to u, and stays there."""
    reached = MP.asin(min(u, 1))
    return fourier([(0, reached, 0, 1), (reached, MP.pi - reached, u, 0), (MP.pi - reached, MP.pi, 0, 1)])[0]


def beyond(u):
    """What is 0 up to u, and then follows the sine."""
    reached = MP.asin(min(u, 1))
    return fourier([(reached, MP.pi - reached, -u, 1)])[0]


def play(u):
    """What rests from the top of the sine on, until it has come down by the gap 1 - u, and then is dragged along."""
    gap = min(1 - u, 2)
    taken_up = MP.pi - MP.asin(1 - gap)
    return fourier([(MP.pi / 2, taken_up, 1 - gap / 2, 0), (taken_up, 3 * MP.pi / 2, gap / 2, 1)])


def stairs(u):
    """Steps of the height 2 u, at each odd multiple of u."""
    edges = (MP.asin(i * u) for i in range(1, int(1 / u) + 1, 2))
    return fourier([(edge, MP.pi - edge, 2 * u, 0) for edge in edges])[0]


HARMONICS = {
    "limiter": limited,
    "deadband": beyond,
    "following": lambda u: play(u)[0],
    "lagging": lambda u: play(u)[1],
    "quantiser": stairs,
}
"""First harmonics by their names, from the Fourier integrals of what the elements do."""


def digits(expression, values):
    """An expression in 60 digits (or as many as MP has)."""
    if expression in values:
        return values[expression]
    if expression.is_Rational:
        return MP.mpf(int(expression.p)) / int(expression.q)
    parts = [digits(x, values) for x in expression.args]
    if expression.is_Add:
        return MP.fsum(parts)
    if expression.is_Mul:
        return MP.fprod(parts)
    if expression.is_Pow:
        return MP.power(*parts)
    if expression.func.__name__ in HARMONICS:
        return HARMONICS[expression.func.__name__](*parts)
    return {pi: MP.pi, I: MP.mpc(0, 1)}.get(expression) or {exp: MP.exp, cosh: MP.cosh, sinh: MP.sinh}[expression.func](
        *parts
    )


def felt(scene, parameters, omega):
    """H_env and H_perc at a frequency, by the equations of the scene's elements, one after the other."""
    values = {hs.s: MP.mpc(0, omega), **parameters}
    environment = digits(scene.environment.dynamics, values)
    perceived = digits((scene.rendered or scene.environment).dynamics, values)
    for effect in scene.effects:
        a, b, c, d = (digits(entry, values) for entry in effect.dynamics)
        perceived = (a * perceived + b) / (c * perceived + d)
    return environment, perceived


def expected(scene, parameters, omega):
    """Each quantity and the size that its error is judged by; at omega = 0, the limit."""
    if omega == 0:  # so near to 0 that nothing but the limit is left, with digits to spare
        MP.dps, omega = 1300, MP.mpf(10) ** -400
    try:
        environment, perceived = felt(scene, parameters, omega)
        difference, size = perceived - environment, abs(environment)
        relative = difference / environment
        force, ratio = size + abs(perceived), 1 + abs(perceived) / size
        values = [difference.real, difference.imag, abs(difference.real) / size, abs(difference.imag) / size,
                  relative.real, relative.imag, environment.real, environment.imag, perceived.real, perceived.imag]  # fmt: skip
        return list(
            zip(values, [ratio if name.startswith(("ratio", "relative")) else force for name in FIELDS], strict=True)
        )
    finally:
        MP.dps = 60


@dataclass(frozen=True)
class Case:
    """One generated function, and the points at which it is called."""

    scene: hs.Scene
    name: str
    symbolic: bool
    points: tuple[tuple[float, ...], ...]

    def parameters(self, point):
        given = point[1:] if self.symbolic else [p.value for p in self.scene.parameters]
        return {
            p.symbol: MP.mpf(x) if self.symbolic else digits(x, {})
            for p, x in zip(self.scene.parameters, given, strict=True)
        }


FREQUENCIES = (0.0, 1e-6, 1e4)


def points_of(scene, *, symbolic):
    chance = random.Random(str(scene.environment.dynamics))
    for _ in range(3 if symbolic else 1):
        values = [value_near(p, chance) for p in scene.parameters] if symbolic else []
        for omega in (*FREQUENCIES, *(10 ** chance.uniform(-2, 3) for _ in range(6))):
            yield (omega, *values)


def value_near(parameter, chance):
    if parameter.symbol.name == "alpha":
        return chance.uniform(0.1, 0.9)
    return nearest_double(parameter.value) * 10 ** chance.uniform(-0.5, 0.5)


CASES = [
    Case(
        scene, f"case_{n}_{'symbolic' if symbolic else 'numeric'}", symbolic, tuple(points_of(scene, symbolic=symbolic))
    )
    for n, scene in enumerate(SCENES.values())
    for symbolic in (True, False)
]


LABELS = [f"{name}, {kind}" for name in SCENES for kind in ("symbolic", "numeric")]


@cache
def truth(n: int):
    case = CASES[n]
    return [expected(case.scene, case.parameters(point), point[0]) for point in case.points]


def run(command: Sequence[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout


def in_numpy(sources: Mapping[str, str], folder: Path) -> str:
    lines = []
    for case in CASES:
        with np.errstate(all="raise"):  # what the user chose is neither in the way nor changed
            values = function_of(sources[case.name], case.name)(*np.array(case.points).T)
            assert np.geterr()["divide"] == "raise"
        lines += [" ".join(map(repr, map(float, row))) for row in np.array(values).T]
    return "\n".join(lines)


def in_c(sources: Mapping[str, str], folder: Path) -> str:
    declarations = [re.search(r"#ifndef \w+_H\n.*?#endif[^\n]*\n", text, re.DOTALL)[0] for text in sources.values()]
    calls = []
    for case in CASES:
        shown = " ".join(["%.17g"] * len(FIELDS))
        fields = ", ".join(f"v.{name}" for name in FIELDS)
        rows = "\n".join(
            f'    {case.name}({", ".join(map(repr, p))}, &v); printf("{shown}\\n", {fields});' for p in case.points
        )
        calls.append(f"  {{ {case.name}_values v;\n{rows}\n  }}")
    main = "\n".join(["#include <stdio.h>", *declarations, "int main(void) {", *calls, "return 0; }"])
    for name, text in {**sources, "main": main}.items():
        (folder / f"{name}.c").write_text(text, encoding="utf-8")
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion"]
    run(["cc", *strict, *(f"{name}.c" for name in sources), "main.c", "-o", "main", "-lm"], folder)
    return run([str(folder / "main")], folder)


def in_octave(sources: Mapping[str, str], folder: Path) -> str:
    lines = ["1;", "more off;"]
    for case in CASES:
        columns = ", ".join(str(list(column)) for column in zip(*case.points, strict=True))
        values = "; ".join(f"v.{name}" for name in FIELDS)
        lines += [f"v = {case.name}({columns});", f'fprintf("{" ".join(["%.17g"] * len(FIELDS))}\\n", [{values}]);']
    for name, text in {**sources, "main": "\n".join(lines)}.items():
        (folder / f"{name}.m").write_text(text, encoding="utf-8")
    return run(["octave-cli", "--norc", "main.m"], folder)


def in_javascript(sources: Mapping[str, str], folder: Path) -> str:
    lines = ["const FIELDS = " + json.dumps(FIELDS) + ";"]
    for case in CASES:
        lines.append(
            f"for (const p of {json.dumps(case.points)}) {{ const v = require('./{case.name}.js').{case.name}(...p);"
        )
        lines.append("console.log(FIELDS.map(x => String(v[x])).join(' ')); }")
    for name, text in {**sources, "main": "\n".join(lines)}.items():
        (folder / f"{name}.js").write_text(text, encoding="utf-8")
    return run(["node", "main.js"], folder)


RUNNERS: dict[Language, tuple[str, Callable[[Mapping[str, str], Path], str]]] = {
    Language.NUMPY: ("", in_numpy),
    Language.C: ("cc", in_c),
    Language.OCTAVE: ("octave-cli", in_octave),
    Language.JAVASCRIPT: ("node", in_javascript),
}


@cache
def source(n: int, language: Language) -> str:
    return program(n).code(language, name=CASES[n].name)


@cache
def program(n: int):
    return scene_program(CASES[n].scene, None if CASES[n].symbolic else ())


def computed(language: Language, folder: Path) -> list[list[list[float]]]:
    """For each case, the rows of values that the code of a language computes: everything in one run."""
    program_name, runner = RUNNERS[language]
    required(program_name, not program_name or shutil.which(program_name))
    lines = iter(runner({case.name: source(n, language) for n, case in enumerate(CASES)}, folder).splitlines())
    rows = [[[float(x) for x in next(lines).split()] for _ in case.points] for case in CASES]
    assert next(lines, None) is None
    return rows


def agrees(value: float, exact, size) -> bool:
    if abs(exact) > 1e60:
        return not np.isfinite(value)
    return size > 1e60 or abs(value - exact) <= TOLERANCE * size + DUST


@pytest.mark.slow
@pytest.mark.parametrize("language", often(Language, lambda x: x is Language.NUMPY), ids=lambda x: x.name)
def test_the_code_has_the_values_of_the_physics(language, tmp_path):
    """One test for a language: all scenes, in one run of its program."""
    wrong = []
    for n, rows in enumerate(computed(language, tmp_path)):
        for point, row, wanted in zip(CASES[n].points, rows, truth(n), strict=True):
            for name, value, (exact, size) in zip(FIELDS, row, wanted, strict=True):
                if LABELS[n].startswith("hold alone") and name.startswith("ratio"):
                    size = abs(exact)  # it keeps its digits, also at 1e-6 rad/s, where r_r is 1e-19
                if not agrees(value, exact, size):
                    wrong.append((LABELS[n], name, point, value, MP.nstr(exact, 17)))
    assert wrong == []


def at_points(text: str, language: Language, points: Sequence[Sequence[float]], folder: Path) -> list[float]:
    """The result y of a function f of two numbers, in its own language."""
    program_name, _ = RUNNERS[language]
    required(program_name, not program_name or shutil.which(program_name))
    columns = [list(x) for x in zip(*points, strict=True)]
    if language is Language.NUMPY:
        return list(map(float, function_of(text, "f")(*np.array(columns)).y))
    if language is Language.OCTAVE:
        rest = f'v = f({columns[0]}, {columns[1]}); fprintf("%.17g\\n", v.y);'
    elif language is Language.C:
        rest = "".join(f'f({x!r}, {y!r}, &v); printf("%.17g\\n", v.y);\n' for x, y in points)
        rest = f"#include <stdio.h>\nint main(void) {{ f_values v;\n{rest}return 0; }}\n"
    else:
        rest = "".join(f"console.log(f({x!r}, {y!r}).y);\n" for x, y in points)
    start = "1;\n" if language is Language.OCTAVE else ""
    (folder / f"main.{language.value}").write_text(f"{start}{text}\n{rest}\n", encoding="utf-8")
    command = {
        Language.C: "cc -std=c99 -Wall -Wextra -Werror -pedantic main.c -o main -lm && ./main",
        Language.OCTAVE: "octave-cli --norc main.m",
        Language.JAVASCRIPT: "node main.js",
    }[language]
    return list(map(float, run(["sh", "-c", command], folder).split()))


@pytest.mark.few("NUMPY", "JAVASCRIPT")
@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_code_takes_an_encoder_of_very_many_steps_for_none(language, tmp_path):
    """1 up to u = q/(2 A) = 5e-6, beside the sum: 1 + 16/pi zeta(-1/2, t) u^(3/2), t the part of the last step that is left."""
    q, a = symbols("q a", positive=True)
    text = code({"y": effects.encoder(q, a).matrix[0]}, [q, a], language, "f")
    given = [(x, 1.0) for x in (5e-324, 1e-300, 1e-12, 1e-6, 1e-5, 1.02e-5, 2e-3, 0.09, 0.9, 1.999, 2.0, 3.0)]
    values = at_points(text, language, given, tmp_path)
    for (size, _), value in zip(given, values, strict=True):
        u = MP.mpf(size) / 2
        if u < 1e-5:
            t = (1 / u + 1) / 2 % 1
            wanted = 1 + 16 / MP.pi * MP.zeta(MP.mpf(-1) / 2, t or 1) * u**1.5
            assert value == (1 if u <= 5e-6 else pytest.approx(float(wanted), rel=1e-12))
            assert abs(value - wanted) < 1.2e-8 or u > 5e-6
        else:
            assert value == pytest.approx(float(stairs(u)), rel=1e-12, abs=1e-12)


@pytest.mark.slow
def test_enough_of_the_comparisons_judge_a_digit():
    """A part that is far below its size would be taken on trust: most are not, and each quantity is seen."""
    pairs = [
        (name, exact, size)
        for n in range(len(CASES))
        for row in truth(n)
        for name, (exact, size) in zip(FIELDS, row, strict=True)
    ]
    for field in FIELDS:
        seen = [abs(exact) > 1e-3 * size for name, exact, size in pairs if name == field]
        assert sum(seen) > len(seen) / 4


def function_of(text: str, name: str = "distortion"):
    module = types.ModuleType(name)
    exec(compile(text, name, "exec"), module.__dict__)  # noqa: S102 - the code under test
    return getattr(module, name)


def test_arrays_are_broadcast_and_constants_fill_the_shape():
    d = hs.distort(
        environments.kelvin_voigt(Symbol("k", positive=True), 2), effects.delay(Symbol("tau", positive=True))
    )
    f = function_of(distortion_code(d, Language.NUMPY))
    values = f(np.array([[0], [10], [20]]), np.array([100, 200]), 0.01)
    assert {x.shape for x in values} == {(3, 2)}
    assert {x.dtype for x in values} == {np.dtype(float)}
    assert values.environment_real.tolist() == [[100, 200]] * 3
    assert f(3, 100, 0.01).real.shape == ()


def test_the_function_of_the_code_agrees_with_that_of_the_package():
    d = hs.load_scene("sidestick").distortion()
    omega = np.geomspace(0.1, 100, 50)
    for ours, theirs in zip(function_of(distortion_code(d, Language.NUMPY))(omega), d.compile()(omega), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9)


def test_names_longer_than_a_line_leave_the_code_valid():
    names = {"a" * 60: "2", "b" * 60: "3"}
    product = "*".join(names)
    scene = hs.Scene(MSD, (effects.series(f"1/(1 + s*{product})^2", parameters=names),))
    f = function_of(scene_code(scene, Language.NUMPY))
    given = {p.symbol.name: float(p.value) for p in scene.parameters}
    expected = scene.distortion().compile("certified", of=("ratio_real",))(7.0)
    assert float(f(7.0, **given).ratio_real) == pytest.approx(float(expected.ratio_real), rel=1e-12)


def test_a_resonance_without_damping_to_speak_of_gives_no_nan():
    m, b, k = hs.symbols("m b k")
    d = hs.distort(environments.mass_spring_damper(m, b, k), effects.first_order_lag(50))
    f = function_of(distortion_code(d, Language.NUMPY))
    omega = np.sqrt(np.linspace(100, 101, 1001) / 1.7)
    values = f(omega, 1.7, 1e-12, np.linspace(100, 101, 1001))
    assert all(np.isfinite(x).all() for x in values)


def test_a_pole_is_infinite_and_no_warning():
    f = function_of(
        distortion_code(
            hs.distort(environments.kelvin_voigt(100, 2), effects.series("100/(s^2 + 100)")), Language.NUMPY
        )
    )
    assert not np.isfinite(f(10.0).real)


def code_only(text: str, language: Language) -> str:
    """The source without comments and documentation."""
    block, line = {
        Language.NUMPY: (r'"""[\s\S]*?"""', "#.*"),
        Language.C: (r"/\*[\s\S]*?\*/", "$^"),
        Language.OCTAVE: ("$^", "%.*"),
        Language.JAVASCRIPT: (r"/\*[\s\S]*?\*/", "$^"),
    }[language]
    return re.sub(line, "", re.sub(block, "", text))


@pytest.mark.few("OCTAVE")
@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_there_is_no_code_for_an_effect_that_is_absent(language):
    text = code_only(scene_code(hs.load_scene("fu2019"), language), language)
    assert not re.search(r"\b(np\.|Math\.)?(sin|cos|pow|exp|tau|pi|PI|\w*sinc)\b", text)
    delayed = code_only(scene_code(hs.load_scene("delayed-spring"), language), language)
    assert re.search(r"\bcos\(", delayed)
    assert re.search(r"\bdistortion_sinc\(", delayed)
    friction = code_only(scene_code(hs.load_scene("stick-with-friction"), language), language)
    assert re.search(r"\bforce\b", friction)
    assert not re.search(r"sinc|\bcos\b|tau", friction)


@pytest.mark.dear("four-channel-teleoperation-NUMPY")
@pytest.mark.few(15)
@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
@pytest.mark.parametrize("name", NAMES)
def test_the_documentation_lists_every_argument_with_meaning_and_unit(name, language):
    scene = hs.load_scene(name)
    text = " ".join(
        re.sub(r"^\s*(#|%|\*)", "", line).strip() for line in source(2 * NAMES.index(name), language).splitlines()
    )
    assert "rad/s" in text
    for p in scene.parameters:
        unit = "" if p.dimension.name == "RATIO" else p.unit_in(scene.motion) or "SI units"
        assert re.search(
            rf"\b{p.symbol.name}\W[^;]* {p.key.replace('[', '.')[:1]}[^;]* of (?:the|what is rendered) [^;]*{re.escape(unit)};",
            text,
        ), p.symbol
    for word in (
        "Re dH",
        "r_r = |Re dH|/|H_env|",
        "Re(dH/H_env)",
        "H_env(s) =",
        scene.title.split()[0],
        "Source:",
        f"haptisym {hs.__version__}",
    ):
        assert word in text


@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_the_file_needs_no_haptisym_and_its_lines_fit_a_page(language):
    text = source(2 * NAMES.index("steering-wheel"), language)
    assert "import haptisym" not in text
    assert max(map(len, code_only(text, language).splitlines())) <= 110


def written(expressions, symbols):
    """A program of some expressions."""
    write = Writer(tuple({x for e in expressions.values() for x in e.free_symbols} | {*symbols}))
    return write.program({name: write.expression(e) for name, e in expressions.items()})


def code(expressions, symbols, language, name="f"):
    """The code of some expressions."""
    return Source(written(expressions, symbols), tuple(map(Argument, symbols))).code(language, name=name)


@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_whole_powers_are_products_and_numbers_have_all_their_digits(language):
    a, b = hs.symbols("a b")
    text = code_only(code({"y": a**3 / (3 * (a + b) ** 2), "z": Integer(10) ** 30 * a}, [a, b], language), language)
    assert "0.3333333333333333" in text
    assert "1e+30" in text
    assert "pow" not in text
    assert "**" not in text
    assert re.search(r"a\.?\*a\.?\*a", text)


def test_the_numbers_of_a_scene_stand_in_the_code_where_they_are_fixed():
    scene = hs.load_scene("fu2019")
    text = scene_code(scene, Language.C, parameters=["m", "b"])
    assert "double omega, double m, double b, distortion_values" in text
    assert "Fixed values, SI: k = 100, omega_n = 80, zeta = 0.5." in text
    with pytest.raises(hs.SceneError, match="omega_q"):
        scene_code(scene, Language.C, parameters=["omega_q"])


def test_an_argument_on_which_nothing_depends_is_said_to_be_one():
    a, b = hs.symbols("a b")
    text = code({"y": 2 * a}, [a, b], Language.C)
    assert "no result depends on it" in text
    assert "(void)b;" in text


@pytest.mark.parametrize(
    ("arguments", "name", "message"),
    [
        ("a", "f", "need b, which is no argument"),
        ("a b b", "f", "b is an argument"),
        ("a b", "int", '"int" cannot name a function in C'),
        ("a b", "a b", "cannot name a function"),
        ("a b", "x; system(1)", "cannot name a function"),
    ],
)
def test_a_call_that_makes_no_sense_is_refused(arguments, name, message):
    a, b = hs.symbols("a b")
    with pytest.raises(hs.SceneError, match=message):
        code({"y": (a + b) ** 2}, [hs.symbols(x) for x in arguments.split()], Language.C, name)


@pytest.mark.parametrize("text", [HOSTILE, "*/*/", '""""', "???", "a\rb\x0bc\x85d", "\u202e"])
def test_no_text_ends_a_comment(text):
    safe = comment(text)
    assert not re.search(r'\*/|/\*|"|\?\?|\\', safe)
    assert safe.isprintable()


@pytest.mark.slow
def test_the_steps_are_exactly_the_closed_forms():
    d = hs.load_scene("fu2019").symbolic_distortion()
    steps = page_steps(closed(d.chain)).at({})
    wanted = {
        "real": d.real,
        "imag": d.imag,
        "relative_real": d.relative_real,
        "perceived_imag": d.perceived_properties.imag,
    }
    for name, form in wanted.items():
        assert (steps[name] - form).together().expand() == 0
    point = {x: Rational(n, 3) for n, x in enumerate(sorted({hs.omega, *d.free_symbols}, key=str), 2)}
    for name, form in {"ratio_real": d.ratio_real, "ratio_imag": d.ratio_imag}.items():
        assert steps[name].xreplace(point) ** 2 == form.xreplace(point) ** 2
        assert steps[name].xreplace(point) > 0


@pytest.mark.parametrize(
    "number",
    [
        Rational(1, 3),
        pi,
        40 * pi,
        sqrt(2),
        Rational(10**25, 3),
        Rational(1, 10**300),
        -Rational(2, 7),
        Integer(2) ** 60 + 1,
    ],
)
def test_a_number_is_the_double_with_none_nearer(number: Expr) -> None:
    own = nearest_double(number)
    off = abs(Rational(own) - number)
    for other in (nextafter(own, inf), nextafter(own, -inf)):
        assert bool((off <= abs(Rational(other) - number)).simplify()) or off.evalf(50) <= abs(
            Rational(other) - number
        ).evalf(50)


def test_what_cancels_is_zero_and_what_is_too_large_is_refused() -> None:
    hidden = sqrt(2) + sqrt(3) - sqrt(5 + 2 * sqrt(6))
    assert nearest_double(hidden) == 0.0
    assert nearest_double(hidden + Rational(1, 10**20)) == 1e-20
    assert nearest_double(Integer(0)) == 0.0
    with pytest.raises(SceneError, match="is too large for a double, whose largest is 1.8e308"):
        nearest_double(Integer(10) ** 309)


@pytest.mark.parametrize("language", list(Language))
def test_every_name_is_one_that_the_language_allows_and_none_is_taken_twice(language: Language) -> None:
    pick = random.Random(4)
    reserved = sorted(RESERVED[language])
    for _ in range(40):
        names = list(
            {"".join(pick.choice("abλ_ 1-é中") for _ in range(pick.randint(1, 6))) for _ in range(6)}
            | set(pick.sample(reserved, 3))
            | {"x" * pick.choice([60, 61, 70])}
        )
        taken = {"b", "a_1"}
        found = identifiers(names, language, taken)
        assert list(found) == names
        assert len(set(found.values())) == len(names)
        for name, own in found.items():
            assert re.fullmatch("[A-Za-z][A-Za-z0-9_]*", own, re.ASCII), own
            assert own not in RESERVED[language] | taken
            assert len(own) <= 63
            can_stay = (
                re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name, re.ASCII)
                and name not in RESERVED[language] | taken
                and len(name) <= 60
            )
            assert (own == name) == bool(can_stay), (name, own)
    assert not any(keyword.iskeyword(x) for x in identifiers(list(keyword.kwlist), Language.NUMPY).values())
    assert identifiers(["_x", "1a", "中"], language) == {"_x": "p_x", "1a": "p_1a", "中": "p_u4E2D"}
    assert function_name("x" * 60, language) == "x" * 60
    for wrong in ("x" * 61, reserved[0], "1x", "a b", ""):
        with pytest.raises(SceneError):
            function_name(wrong, language)
    assert Language.of(language) is Language.of(language.name) is Language.of(language.name.lower()) is language
    assert comment("what? why?? no???") == "what? why? ? no? ? ?"
    with pytest.raises(SceneError, match="for Julia take c"):
        Language.of("julia")
    for unknown in ("fortran", 3):
        with pytest.raises(SceneError, match="is none of numpy, c, octave, javascript"):
            Language.of(unknown)  # type: ignore[arg-type]


a, b = symbols("a b", positive=True)


WHOLE = [0, 1, 7, 10**6, 10**15 - 1, 10**15, 2**53, 2**53 + 1, 10**20, 10**300]


def in_code(number: Expr, language: Language) -> str:
    """How a language writes a number."""
    write = Writer(())
    program = write.program({"y": write.expression(number)})
    return CodeReader(program, set(), dialect=DIALECTS[language], names={}).results()["y"].text


@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_pi_alone_keeps_its_name_in_code_and_with_a_number_it_is_one_double(language: Language) -> None:
    assert "pi" in in_code(pi, language).lower()
    for number in (3 * pi, pi * sqrt(2)):
        assert float(in_code(number, language)) == nearest_double(number)


@pytest.mark.parametrize("language", Language, ids=lambda x: x.name)
def test_a_number_in_code_reads_back_as_the_double_nearest_to_it(language: Language) -> None:
    """Whole numbers beyond all doubles' digits have a point or an exponent: languages read others as machine integers."""
    for value in (*map(Integer, WHOLE), Rational(1, 3), Rational(10**25, 3), Rational(123456789, 1000)):
        for sign in (1, -1):
            text = in_code(sign * value, language)
            assert float(text) == float(sign * value), text
            assert len(text.lstrip("-")) <= 15 or re.search(r"[.e]", text), text


@given(EXPRESSIONS)
@examples(20)
def test_any_formula_in_code_has_its_value(form) -> None:
    symbols = sorted(form.free_symbols, key=str)
    assume(symbols and not form.has(Abs))
    at = {x: Rational(37 + 29 * i, 100) for i, x in enumerate(symbols)}
    f = function_of(code({"y": form}, symbols, Language.NUMPY), "f")
    assert float(f(*map(float, at.values())).y) == pytest.approx(float(form.xreplace(at).evalf(30)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("language", [Language.NUMPY, Language.OCTAVE], ids=lambda x: x.name)
def test_a_power_of_a_power_stands_in_brackets_on_whichever_side_it_is(language: Language) -> None:
    """NumPy takes the right one first where there are none, Octave the left one."""
    x, y, z = Symbol("x"), Symbol("y"), Symbol("z")
    for form, shown in (((x**y) ** z, "(x^y)^z"), (x ** (y**z), "x^(y^z)")):
        text = code_only(code({"r": form}, [x, y, z], language), language)
        assert shown in text.replace(".^", "^").replace("**", "^")


def test_a_parameter_may_have_the_name_of_what_the_code_returns() -> None:
    own = hs.environments.expression("m*s^2 + DistortionValues", parameters={"m": 1, "DistortionValues": 100})
    code = hs.distortion_code(hs.Scene(own, (hs.effects.first_order_lag(20),)).symbolic_distortion(), "numpy")
    space: dict[str, object] = {}
    exec(code, space)  # noqa: S102
    values = space["distortion"](10.0, 100.0, 2.0, 20.0)  # H_env = 100 - 2*10^2
    assert float(values.environment_real) == -100
