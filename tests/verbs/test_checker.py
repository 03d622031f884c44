"""What the checker of certificates computes: formulas, scenes, charts, roots, slabs and waves, each against an independent witness."""

from __future__ import annotations

import random
from fractions import Fraction
from functools import partial, reduce
from itertools import pairwise, product
from typing import Any

import flint
import mpmath
import pint
import pytest
from certificates import CANCELLING
from marks import often
from refusals import refusal
from sympy import Rational, pi

from haptisym.model.quantities import Dimension, read_unit
from haptisym.model.quantities import quantity as read_quantity
from haptisym_check import RefusedError, chart, delayterms, requirement
from haptisym_check import scene as scenes
from haptisym_check.delayterms import ORDER, SCALE
from haptisym_check.polynomials import PI, OmegaFactor
from haptisym_check.scene import CATALOGUE, FREE, PARTS, DimensionedNumber, FactoredNumber, SceneFile
from haptisym_check.scene import quantity as checked_quantity
from haptisym_check.values import ONE, ChainPoint, GaussianValue, Ratio, combined, degree

MP = mpmath.mp.clone()
MP.prec = 600
SEEDS = range(12)


def refused(work: Any, /, *given: Any, **named: Any) -> bool:
    try:
        work(*given, **named)
    except RefusedError:
        return True
    return False


def expanded(roots: list[tuple[int, int]]) -> list[list[int]]:
    """Rows of the product of all (a + b x)."""
    p = [1]
    for a, b in roots:
        p = [a * x + b * y for x, y in zip([*p, 0], [0, *p], strict=True)]
    return [[c] for c in p]


def sign(x: Any) -> int:
    return int(x > 0) - int(x < 0)


def exact(x: Fraction | int) -> Any:
    return MP.mpf(Fraction(x).numerator) / Fraction(x).denominator


# Formulas, units, quantities


def written(draw: random.Random, depth: int) -> tuple[str, str]:
    """A formula, and the same for Python."""
    if depth == 0 or draw.random() < 0.2:
        text = draw.choice(["7", "3", "0.5", "2.5e1", "1.25E-1", ".5", "4.", "a", "bc"])
        return text, text if text in NAMES else f"Fraction('0{text.rstrip('.')}')"
    (x, a), (y, b) = written(draw, depth - 1), written(draw, depth - 1)
    match draw.randint(0, 6):
        case 0:
            n = draw.choice(["2", "3", "-1", "0", "(2)", "( -2 )", "1", "+2"])
            return f"({x}){draw.choice(['^', '**', ' ^ '])}{n}", f"({a})**{n}"
        case 1:
            return f"-({x})", f"(-({a}))"
        case 2:
            return f"({x})", f"({a})"
        case 3 | 4:
            sign_of = draw.choice("*/")
            return f"({x}){sign_of}({y})", f"({a}){sign_of}({b})"
        case _:
            sign_of = draw.choice("+-")
            y, b = (f"({y})", f"({b})") if y[0] in "+-" or sign_of == "-" else (y, b)
            return f"{x} {sign_of} {y}", f"({a} {sign_of} {b})"


NAMES = {"a": Fraction(3, 2), "bc": Fraction(-5)}


def leaf(word: str) -> Fraction:
    return NAMES[word] if word in NAMES else Fraction(word)


def joined(sign_of: str, x: Fraction, y: Fraction) -> Fraction:
    return x + y if sign_of == "+" else x - y if sign_of == "-" else x * y if sign_of == "*" else x / y


@pytest.mark.dear("2")
@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_formulas_have_the_values_that_python_gives_them(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(60):
        text, code = written(draw, 4)
        if len(text) > 900 or len(scenes.WORD.findall(text)) > 400:
            continue
        try:
            true = eval(code, {"Fraction": Fraction, **NAMES})  # noqa: S307  an independent reader of the same formula
        except (ZeroDivisionError, OverflowError):
            continue
        assert scenes.evaluated(text, leaf, joined) == true, text


def test_signs_bind_as_in_mathematics_and_what_may_be_read_in_two_ways_is_refused() -> None:
    for text in ("2 - 3 - 4", "12/3/2", "12/3*2", "2 + 3*4", "-3*2", "-2 + 3", "2*(-3)", "2*-3", "+3", "2-(-3)"):
        assert scenes.evaluated(text, leaf, joined) == eval(text)  # noqa: S307
    for text, value in (
        ("-2^2", -4),
        ("2*3^2", 18),
        ("(2*3)^2", 36),
        ("2^-2", Fraction(1, 4)),
        ("a^2", Fraction(9, 4)),
    ):
        assert scenes.evaluated(text, leaf, joined) == value
    for text in ("", "2 3", "2(3)", "(2)(3)", "2)", "(2", "*2", "2*", "2 + ", "2 ** ", "^2", "2 $ 3", "2$", "$a", "2 é",
                 "2^x", "2^1000", "2^2^1", "()", "2 * * 3", "a b", "+".join(["1"] * 201), "1" + " " * 4000):  # fmt: skip
        assert refused(scenes.evaluated, text, leaf, joined), text
    assert scenes.evaluated("+".join(["1"] * 200), leaf, joined) == 200
    assert scenes.evaluated("a^0.5", lambda word: word, lambda *x: str(x)) == "a^1/2"
    assert scenes.evaluated("a/bc a", leaf, joined, spaced=True) == Fraction(3, 2) / -5 * Fraction(3, 2)
    assert refused(scenes.evaluated, "a 2", leaf, joined, spaced=True)


def test_units_mean_what_haptisym_takes_them_for() -> None:
    known = [name for name in CATALOGUE["units"] if name != "1"]
    prefixed = [f"{x}{name}" for x in CATALOGUE["prefixes"] for name in known if CATALOGUE["units"][name][3]]
    for name in [*known, *prefixed, "N*s/m", "kg*m^2"]:
        factor, exponents = read_unit(name, name, "")
        mine = scenes.quantity(f"1 {name}")
        assert [exponents.get(x, 0) for x in ("mass", "length", "time")] == mine.dimension, name
        assert factor == mine.value.numerator * pi**mine.pi / mine.value.denominator, name


@pytest.mark.dear("10", "9")
@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_quantities_are_those_of_pint(seed: int) -> None:
    draw, registry = random.Random(seed), pint.get_application_registry()
    names = {
        **{x: x for x in ("rad", "deg", "g", "lb", "m", "ft", "s", "min", "N", "lbf", "kgf", "J", "rpm", "kg", "mm", "kN", "ms", "nm")},
        "t": "metric_ton", "rev": "turn", "in": "inch", "Hz": "(turn/s)", "µs": "us", "MHz": "(1e6*turn/s)",
    }  # fmt: skip
    for _ in range(6):
        number, words = draw.choice(["3", "0.25", "1e2", "-7"]), draw.choices([*names], k=draw.randint(1, 3))
        signs = [draw.choice(["*", "/", " ", "·", "⋅"]) for _ in words[1:]]
        text = number + " " + words[0] + "".join(a + b for a, b in zip(signs, words[1:], strict=True))
        own = "".join(("/" if a == "/" else "*") + names[b] for a, b in zip(["*", *signs], words, strict=True))
        found, true = scenes.quantity(text), registry.Quantity(f"1.0{own}").to_base_units()
        assert float(found.value) * float(MP.pi) ** found.pi == pytest.approx(float(number) * true.magnitude, rel=1e-12)
        dimension = [true.dimensionality.get(f"[{x}]", 0) for x in ("mass", "length", "time")]
        assert found.dimension == pytest.approx(dimension)


def test_quantities_are_exact_and_of_a_range_the_nominal_value_or_the_middle() -> None:
    def number(value: Any, pi: int = 0, dimension: Any = None) -> DimensionedNumber:
        return DimensionedNumber(Fraction(value), pi, dimension)

    newton, stiffness = [1, 1, -2], [1, 0, -2]
    for given, found in (
        ("5", number(5)), ([1, 3], number(2)), ([-3, 1], number(-1)), ([1, 2, 9], number(2)), (["1", "4"], number("5/2")),
        (["1 mm", "4 mm"], number("5/2000", 0, [0, 1, 0])), ("5 N/m +/- 1", number(5, 0, stiffness)), ("5 N/m ± 2 N/m", number(5, 0, stiffness)),
        ("6 N/2", number(3, 0, newton)), ("3/4*4 N", number(3, 0, newton)), ("N*3", number(3, 0, newton)), ("12 N/(2*2)", number(3, 0, newton)),
        ("6/2/s", number(3, 0, [0, 0, -1])), ("-3 °", number("-3/180", 1, [0, 0, 0])), ("20 %", number("1/5", 0, [0, 0, 0])),
        ("2 m²", number(2, 0, [0, 2, 0])), ("3 m³", number(3, 0, [0, 3, 0])), (FREE, FREE),
        ("80 N s^0.3/m", number(80, 0, [1, 0, -Fraction(17, 10)])),
    ):  # fmt: skip
        assert scenes.quantity(given) == found, given
    for wrong in ([1], [1, 2, 3, 4], ["1 s", "2"], ["1 s", "2 m"], ["1 °", "2 rad"], True, None, 1.5, "x", "1 kmin", "1 xs", "1 kk", "5 +/- 1 +/- 2",
                  "5 + 1", "1/0", "1 µ%", "1 kin", "5 mm^0.5", "1 Hz^0.5", "4^0.5", "4^0.5 N", "1" * 500):  # fmt: skip
        assert refused(scenes.quantity, wrong), wrong
    for text, kind in (("1 N/m", "m"), ("1 kg", "k"), ("1 s", "o"), ("1 Hz", "t"), ("1 N", "z")):
        assert refused(scenes.quantity, text, kind)
    for text, kind in (("1 kg m^2", "m"), ("1 N m/rad", "k"), ("1 Hz", "o"), ("1 min", "t"), ("1 %", "z"), ("1", "k")):
        assert not refused(scenes.quantity, text, kind)
    assert DimensionedNumber(Fraction(3, 4), 2).at(5) == (GaussianValue(75, 0, degree(1, 2)), GaussianValue(4))
    assert DimensionedNumber(Fraction(3, 4), -1).at(5) == (GaussianValue(3), GaussianValue(20, 0, degree(1, 1)))


# Scenes

ENVIRONMENT = '[environment]\nmodel = "kelvin-voigt"\nk = 3\nb = 5\n'
LAG = '[[effects]]\nmodel = "first-order-lag"\nomega_c = 7\n'


def at(text: str, x: int = 2, name: str | None = None, others: tuple[Any, ...] = (), **named: Any) -> list[complex]:
    """H_env and H_perc at s = j x; in place of pi stands 3."""
    delays, orders = named.get("delays", ()), named.get("orders", ())
    scene = SceneFile(text.encode(), name, named.get("free"))
    found = scene.at(ChainPoint((GaussianValue(0, x, degree(0)), ONE), 3, delays, orders, others))
    turned = [(top.times(bottom.conjugate()), bottom.times(bottom.conjugate()).re) for top, bottom in found]
    return [complex(Fraction(top.re, size), Fraction(top.im, size)) for top, size in turned]


def effect(model: str, *lines: str) -> str:
    return "\n".join([ENVIRONMENT, "[[effects]]", f'model = "{model}"', *lines, ""])


def environment(model: str, *lines: str) -> str:
    return "\n".join(["[environment]", f'model = "{model}"', *lines, ""])


def test_tables_of_a_scene_have_their_shape_and_no_other() -> None:
    for text in (
        ENVIRONMENT + LAG, f"{ENVIRONMENT}[evaluation]\nband = [1, 2]\njnd = 0.2\n", environment("mass-spring-damper"),
        f'title = "x"\nsource = "y"\n{ENVIRONMENT}[rendered]\nmodel = "kelvin-voigt"\nk = "environment.k"\nb = 0\n',
        f"{ENVIRONMENT}[evaluation]\njnd = {{real = 0.1, imag = 0.2}}\n", environment("expression", 'H = "a*s"', 'parameters = {a = "3 N/m"}'),
        environment("prony", "k0 = 1", "k = [2, 3]", "b = [4, 5]"), effect("shunt", 'Z = "a"', "parameters = {a = 2}"), effect("shunt", 'm = "1 kg"'),
    ):  # fmt: skip
        assert not refused(at, text), text
    for text in (
        "", LAG, "environment = 5", "environment = []", '[environment]\nmodel = ["kelvin-voigt"]\nk = 3\nb = 5\n', "[environment]\nk = 3\nb = 5\n",
        ENVIRONMENT + "c = 1\n", environment("kelvin-voigt", "k = 3"), environment("first-order-lag", "omega_c = 7"), environment("no-model"),
        effect("kelvin-voigt", "k = 3", "b = 5"), effect("first-order-lag"), effect("first-order-lag", "omega_c = 7", "parameters = {a = 1}"),
        effect("series", 'G = "1"', "parameters = 5"), effect("series", 'G = "1"', "parameters = [5]"), effect("shunt Z", "m = 1"), effect("shunt", 'Z = "1"', "m = 1"),
        f"colour = 1\n{ENVIRONMENT}", f"effects = 5\n{ENVIRONMENT}", f"effects = [5]\n{ENVIRONMENT}", f"evaluation = 5\n{ENVIRONMENT}",
        f"{ENVIRONMENT}[evaluation]\nfrom = 0\n", f"{ENVIRONMENT}[evaluation]\nband = [1]\n", f"{ENVIRONMENT}[evaluation]\nband = [1, 2, 3]\n",
        f'{ENVIRONMENT}[evaluation]\nband = "12"\n', f"{ENVIRONMENT}[evaluation]\njnd = {{real = 0.1}}\n",
        f"{ENVIRONMENT}[evaluation]\njnd = {{real = 0.1, imag = 0.1, joint = 0.1}}\n", ENVIRONMENT.replace("3", "nan"), ENVIRONMENT.replace("3", "1e999999999"),
        f"rendered = 5\n{ENVIRONMENT}", f'{ENVIRONMENT}[rendered]\nmodel = "kelvin-voigt"\nk = "environment.m"\nb = 0\n', effect("series", 'G = "s(s)"'),
        '[environment]\nmodel = "kelvin-voigt"\nk = "environment.b"\nb = 5\n', f'{ENVIRONMENT}[[effects]]\nmodel = "first-order-lag"\nomega_c = "environment.k"\n',
        f"environments = []\n{ENVIRONMENT}", f"[environments]\n{ENVIRONMENT}", effect("delay", 'tau = "1 ms"'), effect("series", 'G = "((s^99)^99)^99"'),
        effect("series", 'G = "__import__"'), effect("series", f'G = "{"(" * 900}s{")" * 900}"'),
    ):  # fmt: skip
        assert refused(at, text), text


def test_numbers_of_models_are_in_their_bounds() -> None:
    def clock(delay: object, method: str = '"tustin"') -> str:
        return effect("sampled-loop", 'T = "1 ms"', f"delay = {delay}", f"method = {method}")

    def pade(order: object) -> str:
        return effect("pade-delay", 'tau = "1 ms"', f"order = {order}")

    def prony(k: object, b: object) -> str:
        return environment("prony", "k0 = 1", f"k = {k}", f"b = {b}")

    own: Any = {"delays": (Fraction(1, 1000),), "others": (2,)}
    for text in (clock(0), clock(20), clock(3, '"backward-difference"'), clock(3, '"forward-difference"')):
        assert not refused(at, text, **own)
    for text in (pade(1), pade(10), prony([1], [2]), prony([1] * 20, [2] * 20)):
        assert not refused(at, text)
    for text in (
        *map(clock, (-1, 21, "true", "1.0", '"1"')), *(clock(1, x) for x in ('"zoh"', '["tustin"]', "1")),
        *map(pade, (0, 11, -1, "true", "1.0", '"1"')), effect("pade-delay", 'tau = "1 ms"'), effect("sampled-loop", 'T = "1 ms"', "delay = 1"),
        prony([], []), prony([1], []), prony([1, 2], [3]), prony(1, [2]), prony([1], 2), prony([1] * 21, [2] * 21), environment("prony", "k0 = 1", "k = [1]"),
    ):  # fmt: skip
        assert refused(at, text, **own), text
    for lag, is_refused in (("0", False), ("1 ms", False), ("-1 ms", True), ("1 ms*rev", True), ("1 ms*rad", False)):
        assert refused(at, effect("delay", f'tau = "{lag}"'), **own) == is_refused, lag
    for alpha, fits in (("1/2", True), ("0", False), ("1", False), ("-1/2", False), ("0.5 rev", False), ("3/2", False)):
        text = environment("spring-pot", "k_alpha = 2", f'alpha = "{alpha}"')
        assert refused(at, text, orders=(Fraction(1, 2),), others=((3, 4),)) is not fits, alpha


def test_of_several_environments_one_is_asked_for_by_its_name_or_its_model() -> None:
    def several(*rows: str) -> str:
        return "\n".join(f"[[environments]]\n{row}\n" for row in rows)

    stiff, soft = 'name = "stiff"\nmodel = "kelvin-voigt"\nk = 3\nb = 5', 'model = "mass-spring-damper"\nk = 2'
    felt = f'{soft}\n[environments.rendered]\nmodel = "kelvin-voigt"\nk = "environment.k"\nb = 1'
    assert at(several(stiff, soft), name="stiff") == [3 + 10j] * 2
    assert at(several(stiff, felt), name="mass-spring-damper") == [2, 2 + 2j]
    assert at(several(stiff, soft) + LAG, name="stiff")[0] == 3 + 10j
    for text, name in (
        (several(stiff, soft), None), (several(stiff, soft), "kelvin-voigt"), (several(stiff, soft), "hard"), (several(stiff, stiff), "stiff"),
        (several(stiff, soft) + ENVIRONMENT, "stiff"), (several(stiff) + '[rendered]\nmodel = "kelvin-voigt"\nk = 1\nb = 1\n', "stiff"),
        (ENVIRONMENT, "kelvin-voigt"), ("environments = 5", "stiff"), ("environments = [5]", "stiff"), ("environments = [{}]", "stiff"),
    ):  # fmt: skip
        assert refused(at, text, name=name), (text, name)


def test_bands_thresholds_and_hands_are_those_of_the_file() -> None:
    def told(text: str) -> tuple[list[tuple[Fraction, int]], list[tuple[Fraction, int]]]:
        scene = SceneFile(f"{ENVIRONMENT}{text}".encode(), None)
        return [x[:2] for x in scene.band], [scene.threshold[x][:2] for x in PARTS]

    tenth = (Fraction(1, 10), 0)
    assert told("") == told("[evaluation]\n") == ([(0, 0), (15, 0)], [tenth, tenth])
    assert told('[evaluation]\nband = [1_0.5, "10 Hz"]\n') == ([(Fraction(21, 2), 0), (20, 1)], [tenth, tenth])
    assert told('[evaluation]\njnd = "20 %"\n')[1] == [(Fraction(1, 5), 0)] * 2
    assert told("[evaluation]\njnd = {imag = 0.25, real = 1}\n")[1] == [(1, 0), (Fraction(1, 4), 0)]
    for way, halved in (
        ("0.5_0", True),
        ("5e-1", True),
        ("0.0_5e+1", True),
        ("5_0E-02", True),
        ("+1", False),
        ("0x0_1", False),
        ("0b1", False),
    ):
        assert at(ENVIRONMENT.replace("3", way))[0].real == (0.5 if halved else 1)  # every way of TOML

    def hand(hands: str, name: str) -> dict[str, Any]:
        return SceneFile(f"{ENVIRONMENT}{hands}".encode(), None).hand(name)

    two = '[[hands]]\nname = "a"\nm = 1\nsource = "x"\n[[hands]]\nname = "b"\nm = 2\nk = 3\n'
    assert (hand(two, "a"), hand(two, "b")) == ({"m": 1}, {"m": 2, "k": 3})
    levered = hand('[hand]\nm = "2 kg"\nk = 8\nlever = "50 cm"', "hand")
    assert {key: x.value for key, x in levered.items()} == {"m": Fraction(1, 2), "k": 2}
    assert levered["m"].dimension == [1, 2, 0]
    assert hand("[hand]\nm = 4\n", "hand") == hand("[[hands]]\nm = 4\n", "hand") == {"m": 4}
    assert hand('[hand]\nname = "own"\nm = 4\n', "own") == {"m": 4}
    for hands, name in (
        ("", "hand"), (two, "c"), (two, "hand"), ('[hand]\nname = "own"\nm = 4\n', "hand"), ('[[hands]]\nname = "a"\n[[hands]]\nname = "a"\n', "a"),
        ('[hand]\nmodel = "expression"\nH = "s"\n', "hand"), ("hand = 5\n", "hand"),
    ):  # fmt: skip
        assert refused(hand, hands, name)


def test_a_number_is_left_free_where_its_path_leads_and_pi_is_nowhere_else() -> None:
    text = f"{ENVIRONMENT}{LAG}"
    assert at(text, free=["environment", "k"]) == pytest.approx([3 + 10j, (3 + 10j) * 7 / (7 + 2j)])  # 3 stands for it
    assert at(text, free=["effects", 0, "omega_c"])[1] == pytest.approx((3 + 10j) * 3 / (3 + 2j))
    both = SceneFile(f"{text}[evaluation]\njnd = 0.2\n".encode(), None, ["evaluation", "jnd"]).threshold
    assert both["real"] is both["imag"] is FREE
    one = SceneFile(
        f"{text}[evaluation]\njnd = {{real = 0.2, imag = 0.3}}\n".encode(), None, ["evaluation", "jnd", "imag"]
    )
    assert (one.threshold["real"].value, one.threshold["imag"]) == (Fraction(1, 5), FREE)
    for path in (
        ["environment"], ["environment", "m"], ["environment", "model"], ["effects", "omega_c"], ["effects", 1, "omega_c"], ["effects", -1, "omega_c"],
        ["effects", False, "omega_c"], ["effects", "0", "omega_c"], ["environment", "k", 0], [], ["evaluation", "band", 0], [0], ["environment", 0.0],
    ):  # fmt: skip
        assert refused(at, f"{text}[evaluation]\nband = [1, 2]\n", free=path), path
    for other in (
        f"{text}[evaluation]\njnd = \"1 °\"\n", text.replace("omega_c = 7", 'omega_c = "7 Hz"'), text.replace("b = 5", 'b = "5 N s/m*rev"'),
        f'{text}[[effects]]\nmodel = "series"\nG = "2*pi"\n', f'{text}[[effects]]\nmodel = "coulomb-friction"\nforce = 1\namplitude = 1\n',
    ):  # fmt: skip
        assert refused(at, other, free=["environment", "k"]), other
        assert not refused(at, other)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(6))
def test_chains_have_the_values_of_their_matrices(seed: int) -> None:
    """(A H + B)/(C H + D), one effect after the other, each formula written a second time."""
    draw = random.Random(seed)
    for _ in range(25):
        n = lambda: draw.randint(1, 9)  # noqa: E731
        x, t, re, im = draw.randint(1, 4), draw.randint(-5, 5), n(), n()
        s, u, z = 1j * x, (1 - 1j * t) / (1 + 1j * t), complex(re, im)  # s, exp(-s/4), s^(1/3)
        k, b, m, c = n(), n(), n(), n()
        Z = m * s**2 + b * s + k
        text, H = draw.choice([
            (environment("kelvin-voigt", f"k = {k}", f"b = {b}"), k + b * s),
            (environment("mass-spring-damper", f"m = {m}", f"k = {k}"), m * s**2 + k),
            (environment("maxwell", f"k = {k}", f"b = {b}"), k * b * s / (k + b * s)),
            (environment("zener", f"k0 = {k}", f"k1 = {c}", f"b1 = {b}"), k + c * b * s / (c + b * s)),
            (environment("prony", f"k0 = {k}", f"k = [{b}, {m}]", f"b = [{c}, {k}]"), k + b * c * s / (b + c * s) + m * k * s / (m + k * s)),
            (environment("spring-pot", f"k_alpha = {c}", 'alpha = "1/3"', f"k = {k}"), k + c * z),
            (environment("expression", f'H = "a*s^(4/3) - {c}/s^2"', f"parameters = {{a = {k}}}"), k * s * z - c / s**2),
        ])  # fmt: skip
        felt = H
        for _ in range(draw.randint(0, 3)):
            late = draw.randint(1, 3)
            model, lines, (p, q, r, w) = draw.choice([
                ("first-order-lag", [f"omega_c = {c}"], (c, 0, 0, s + c)),
                ("second-order-lowpass", [f"omega_n = {c}", f"zeta = {b}"], (c**2, 0, 0, s**2 + 2 * b * c * s + c**2)),
                ("delay", [f'tau = "{late}/4"'], (u**late, 0, 0, 1)),
                ("zero-order-hold", [f'T = "{late}/4"'], (1 - u**late, 0, 0, s * late / 4)),
                ("wave-variables", [f"b = {b}", f'tau = "{late}/4"'], (1 + u ** (2 * late), b * s * (1 - u ** (2 * late)), (1 - u ** (2 * late)) / (b * s), 1 + u ** (2 * late))),
                ("series", [f'G = "({c} + s)/{k}"'], (c + s, 0, 0, k)),
                ("shunt", [f"m = {m}", f"b = {b}", f"k = {k}"], (1, Z, 0, 1)),
                ("shunt", [f'Z = "{c}*s^(1/3)"'], (1, c * z, 0, 1)),
                ("compliance", [f"k = {k}", f"b = {b}"], (1, 0, 1 / (k + b * s), 1)),
                ("coulomb-friction", [f"force = {c}", f"amplitude = {b}"], (1, 4j * c / (3 * b), 0, 1)),
                ("admittance-display", [f'P = "{k} + s"'], (1, 0, 0, k + s)),
                ("two-port", [f'A = "{k}"', f'B = "s*{b}"', f'C = "1/(s + {c})"', f'D = "{m}"'], (k, b * s, 1 / (s + c), m)),
            ])  # fmt: skip
            text += "\n".join(["[[effects]]", f'model = "{model}"', *lines, ""])
            H = (p * H + q) / (r * H + w)
        own: Any = {"delays": (Fraction(1, 4),), "orders": (Fraction(1, 3),), "others": (t, (re, im))}
        assert at(text, x, **own) == pytest.approx([felt, H], rel=1e-9), text


@pytest.mark.parametrize(("formula", "same"), CANCELLING)
def test_powers_of_s_that_cancel_leave_the_same_value_at_any_values_of_the_powers(formula: str, same: str) -> None:
    """Exponents are added, as rational numbers: s^(1/4) is no root of s^(1/2) here, which is one of s = 8 j."""
    orders = tuple(Fraction(n, 20) for n in (4, 5, 6, 10, 14, 15))
    powers = tuple((2, 2) if order == Fraction(1, 2) else (3 + n, 7 - 2 * n) for n, order in enumerate(orders))
    one, other = (at(environment("expression", f'H = "{x}"'), 8, orders=orders, others=powers) for x in (formula, same))
    assert one == pytest.approx(other, rel=1e-12)


def test_a_clock_comes_first_and_turns_the_s_of_what_is_rendered() -> None:
    loop = '[[effects]]\nmodel = "sampled-loop"\nT = 2\nmethod = "{}"\ndelay = {}\n'
    t, x, T, own = 3, 5, 2, {"delays": (Fraction(2),), "others": (3,)}
    s, u = 1j * x, (1 - 1j * t) / (1 + 1j * t)
    turned = {
        "backward-difference": (1 - u) / T, "tustin": 2 * (1 - u) / (T * (1 + u)), "forward-difference": (1 - u) / (T * u),
    }  # fmt: skip
    for (method, clock), delay in product(turned.items(), (0, 1, 3)):
        text, true = ENVIRONMENT + loop.format(method, delay), (3 + 5 * clock) * u**delay * (1 - u) / (s * T)
        assert at(text, x, **own) == pytest.approx([3 + 5 * s, true])
        assert at(f'{text}[[effects]]\nmodel = "shunt"\nk = 4\n', x, **own)[1] == pytest.approx(true + 4)
    one = loop.format("tustin", 1)
    for text in (ENVIRONMENT + LAG + one, ENVIRONMENT + one + one, ENVIRONMENT + LAG + one + one):
        assert refused(at, text, **own)


def test_delays_and_powers_that_a_proof_does_not_have_are_refused() -> None:
    s, third, half = (GaussianValue(2, 1, degree(0)), ONE), Fraction(1, 3), Fraction(1, 2)
    point = ChainPoint(s, 4, (Fraction(1, 5), Fraction(1, 7)), (third, half), (2, 5, (11, 13), (17, 19)))
    assert point.delayed(Fraction(1, 5)) == GaussianValue(1, -2, degree(2))
    assert point.delayed(Fraction(3, 7)) == GaussianValue(1, -5, degree(3)).power(3)
    lags = ("64/7", "65/7", "1/10", "-1/5", "-3/7")
    assert [refused(point.delayed, Fraction(x)) for x in lags] == [False, True, True, True, True]
    powers = ("5/2", "-2/3", "1/4", "99", "100", "-99", "-100")
    assert [refused(point.raised, Fraction(x)) for x in powers] == [False, False, True, False, True, False, True]
    assert not refused(GaussianValue(2**29_997).times, GaussianValue(2))
    assert refused(GaussianValue(2**29_997).times, GaussianValue(4))


# Rule 1: the ten functions, and what links them to a proof


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_ten_functions_are_those_of_two_dynamics(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(10):
        a, b, c, d, e = (draw.randint(-9, 9) or 1 for _ in range(5))
        limits = draw.choice([("1/10", "3/7"), ("7 rev", "2/9")])
        text = environment("expression", f'H = "({a} + {b}*s)/(s^2 + {c}*s + 40)"') + (
            f'[[effects]]\nmodel = "two-port"\nA = "1"\nB = "{d}*s"\nC = "0"\nD = "{e}"\n'
            f'[evaluation]\njnd = {{ real = "{limits[0]}", imag = "{limits[1]}" }}\n'
        )
        x, p = draw.randint(1, 9), 5  # in place of omega and of pi
        found = scenes.functions(SceneFile(text.encode(), None), (), (), GaussianValue(x, 0, degree(0)), p)
        s = MP.mpc(0, x)
        H = (a + b * s) / (s**2 + c * s + 40)
        G = (H + d * s) / e
        true = {"environment": H, "perceived": G, "difference": G - H, "sum": G + H}
        thresholds = {
            "real": 14 * MP.mpf(p) if "rev" in limits[0] else MP.mpf(1) / 10,
            "imag": exact(Fraction(limits[1])),
        }
        for part, name in product(PARTS, [*true, "excess"]):
            top, bottom = found[f"{name}.{part}"]
            own = getattr(true.get(name, G - H), part)
            own = own if name != "excess" else own**2 / abs(H) ** 2 - thresholds[part] ** 2
            assert abs(MP.mpf(top.re) / bottom.re - own) < 1e-60 * (1 + abs(own)), name
            assert top.im == bottom.im == 0


def test_a_function_that_differs_anywhere_is_not_that_of_the_scene() -> None:
    """omega^2 + pi, and polynomials that have its value at many places of a grid."""
    good, one = OmegaFactor([[0, 1], [0], [1]]), {"it": {"number": "1", "powers": [[0, 1]]}}
    square = lambda x, pi, *_: {"it": (x.times(x).plus(GaussianValue(pi, 0, degree(1))), ONE)}  # noqa: E731
    linked = lambda told, factors, scene=square: scenes.link(told, ["it"], factors, scene, 5)  # noqa: E731
    assert linked(one, [good])["it"].number == 1
    assert refused(linked, {"it": {"number": "2", "powers": [[0, 1]]}}, [good])
    for rows in ([[0, 1], [1], [1]], [[1, 1], [0], [1]], [[0, 1], [0, 1], [1]], [[0, 0, 1], [0], [1]], [[3], [0], [1]]):
        assert refused(linked, one, [OmegaFactor(rows)])
    for n in range(5):
        away = expanded([(-k, 1) for k in range(n)])  # zero at the first places of a grid
        rows = [[c] for c in (x + y for (x,), y in zip([*away, *[[0]] * 3], [0, 0, 1, *[0] * 9], strict=False))]
        assert refused(linked, one, [OmegaFactor([[rows[0][0], 1], *rows[1:][: max(2, n)]])]), n
        in_pi = [c for (c,) in expanded([(-k, 1) for k in range(1, n + 1)])]
        assert refused(
            linked,
            one,
            [OmegaFactor([[x + y for x, y in zip([0, 1, *[0] * 9], [*in_pi, *[0] * 9], strict=False)], [0], [1]])],
        )
    for n in range(2, 6):  # x (x - 1) ... over one denominator, and over one that differs only where that is not zero
        above, wrong = OmegaFactor(expanded([(-k, 1) for k in range(n)])), expanded([(-k, 1) for k in range(n, 2 * n)])
        rows = [[([5, 1][i] if i < 2 else 0) + x] for i, (x,) in enumerate(wrong)]

        def ratio(x: GaussianValue, *_: Any, n: int = n) -> dict[str, Ratio]:
            return {
                "it": (
                    reduce(GaussianValue.times, [x.plus(GaussianValue(-k)) for k in range(n)]),
                    x.plus(GaussianValue(5)),
                )
            }

        quotient = {"it": {"number": "1", "powers": [[0, 1], [1, -1]]}}
        assert not refused(linked, quotient, [above, OmegaFactor([[5], [1]])], ratio)
        assert refused(linked, quotient, [above, OmegaFactor(rows)], ratio)
    twice = {"it": {"number": "1", "powers": [[0, 1], [1, 1], [2, -1]]}}
    assert linked(twice, [good, OmegaFactor([[7], [1]]), OmegaFactor([[7], [1]])])["it"].powers == {0: 1, 1: 1, 2: -1}
    with pytest.raises(RefusedError, match="too high"):
        scenes.link(one, ["it"], [good], square, 10**7)
    with pytest.raises(RefusedError, match="nowhere defined"):
        linked(one, [good], lambda x, *_: {"it": (x, GaussianValue(0))})


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_functions_with_tangents_and_powers_are_told_from_others(seed: int) -> None:
    """A sum of tangents and of Re and Im of powers, with one coefficient wrong or none."""
    draw = random.Random(seed)
    keys = [(k, n, m) for k in range(3) for n in range(3) for m in range(3 - n)]
    rows = {key: draw.randint(1, 9) for key in keys if draw.random() < 0.5} | {(2, 0, 1): 3}

    def scene(_: GaussianValue, __: int, *others: Any) -> dict[str, Ratio]:
        t, (re, im) = others
        terms = [GaussianValue(c * t**k * re**n * im**m, 0, (0, 0, k, n + m, 0, 0)) for (k, n, m), c in rows.items()]
        return {"it": (reduce(GaussianValue.plus, terms), GaussianValue(1 + t * t, 0, degree(2, 2)))}

    def accepted(own: dict[tuple[int, int, int], int]) -> bool:
        told = {"waves": [2], "terms": [[list(key), [[str(c)]]] for key, c in own.items() if c]}
        factor = delayterms.WaveFactor(told, (Fraction(1, 3),), (Fraction(1, 2),))
        return not refused(scenes.link, {"it": {"number": "1", "powers": [[0, 1]]}}, ["it"], [factor], scene, 5, (1, 1))

    assert accepted(rows)
    assert not any(accepted(rows | {key: rows.get(key, 0) + draw.choice([-1, 1])}) for key in keys)


def test_a_product_has_each_factor_once_and_turns_the_circle_whole() -> None:
    factors = [OmegaFactor([[-3], [1]]), OmegaFactor([[-3], [2]])]
    assert FactoredNumber({"number": "2/3", "powers": [[0, 1], [1, -2]]}, factors).powers == {0: 1, 1: -2}
    for told, why in (
        ({"number": "2", "powers": [[0, 1], [0, 2]]}, "stands twice"), ({"number": "0", "powers": [[1, 1]]}, "zero everywhere"),
        ({"number": "2", "powers": [[2, 1]]}, "whole number from 0 to 1"), ({"number": "2", "powers": [[-1, 1]]}, "whole number from 0 to 1"),
        ({"number": "2", "powers": [[0, 101]]}, "from -100 to 100"), ({"number": "2", "powers": [[0, True]]}, "whole number"),
        ({"number": "2", "powers": [[2.0, 1]]}, "whole number"), ({"number": 2, "powers": []}, "not written as one"),
        ({"number": "2", "powers": [[0, 1, 1]]}, "a list of 2 to 2"), ({"number": "2"}, "with the keys"),
    ):  # fmt: skip
        with pytest.raises(RefusedError, match=why):
            FactoredNumber(told, factors)
    turned = [delayterms.WaveFactor({"waves": [n], "terms": [[[0], [["1"]]]]}, (Fraction(1),)) for n in (1, 2)]
    with pytest.raises(RefusedError, match="changes its sign in a turn"):
        FactoredNumber({"number": "1", "powers": [[0, 1]]}, turned)
    top, bottom = FactoredNumber({"number": "1", "powers": [[0, 2], [1, -3]]}, turned).at(
        [GaussianValue(5), GaussianValue(7)], [GaussianValue(10)]
    )
    assert (top.re, bottom.re) == (25 * 100, 343)  # cos^2 = 1/(1 + t^2)


# Rules 2 to 4: charts against signs of the functions at and between all of their zeros


def band(low: object, high: object) -> SceneFile:
    """A scene on that band."""
    return SceneFile(f'{ENVIRONMENT}[evaluation]\nband = ["{low}", "{high}"]\n'.encode(), None)


class Drawn:
    """Ten products of linear factors with known roots, on the band from 0 or 1 to 6, and their cells."""

    def __init__(self, seed: int) -> None:
        draw = random.Random(seed)
        self.low = draw.choice([0, 1])
        places = draw.sample(range(self.low, 7), draw.randint(1, 5))
        self.roots = [Fraction(n) + (Fraction(draw.randint(-1, 1), 5) if self.low < n < 6 else 0) for n in places]
        self.factors = [OmegaFactor(expanded([(-x.numerator, x.denominator)])) for x in self.roots]
        self.factors.append(OmegaFactor([[9], [0], [1]]))
        self.told: dict[str, FactoredNumber] = {}
        for name in (f"{x}.{part}" for x in chart.CURVES for part in PARTS):
            powers = [[i, draw.choice([-2, -1, 1, 1, 2])] for i in range(len(self.factors)) if draw.random() < 0.6]
            number = draw.choice(["1", "-1", "3/7", "-2", "0"]) if draw.random() < 0.9 else "0"
            row = {"number": number, "powers": [] if number == "0" else powers}
            self.told[name] = FactoredNumber(row, self.factors)
        self.inside = sorted(x for x in self.roots if self.low < x < 6)
        self.places = [Fraction(self.low), *self.inside, Fraction(6)]
        self.between = [(a + b) / 2 for a, b in pairwise(self.places)]
        self.points = sorted({Fraction(self.low), Fraction(6), *self.between})
        self.enclosures = [
            [x, x] if draw.random() < 0.5 or x in (self.low, 6) else [x - Fraction(1, 50), x + Fraction(1, 60)]
            for x in self.places
        ]

    def chart(self) -> chart.PlaceTable:
        return chart.PlaceTable(band(self.low, 6), self.points, self.factors, self.enclosures)

    def value(self, name: str, x: Fraction) -> int | None:
        """The sign at a place; None at a pole."""
        found = self.told[name].number
        for i, n in self.told[name].powers.items():
            own = (x - self.roots[i]) if i < len(self.roots) else x**2 + 9
            if own == 0 and n < 0:
                return None
            found *= own**n
        return sign(found)

    def order(self, name: str, x: Fraction) -> int:
        return sum(n for i, n in self.told[name].powers.items() if i < len(self.roots) and self.roots[i] == x)

    def around(self, name: str, x: Fraction) -> list[int]:
        """The signs just before and just after."""
        return [self.value(name, x + way * Fraction(1, 10**6)) for way in (-1, 1)]  # type: ignore[misc]

    def limit(self, name: str, x: Fraction) -> int:
        """The sign at a place; at a pole that on both sides, 0 if they differ."""
        own, (before, after) = self.value(name, x), self.around(name, x)
        return own if own is not None else (before if before == after else 0)

    def percept(self, part: str, x: Fraction) -> tuple[str, str] | None:
        """What is felt at a frequency that is no zero: eqs. (11) to (14) of the paper."""
        env, perc, excess, change, both = (self.value(f"{name}.{part}", x) or 0 for name in chart.CURVES)
        if excess <= 0 or (part == "imag" and perc < 0):
            return None
        louder = change * both  # of |G|^2 - |H|^2
        word = "higher" if louder > 0 else "lower" if louder < 0 else "equal"
        names = {(1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness"}
        return ("damping" if part == "imag" else names[env or perc, perc or env]), word


def merged(line: list[Any]) -> list[tuple[int, int, Any]]:
    """Of values at places and between them in turn: where one stays, from place to place."""
    found: list[tuple[int, int, Any]] = []
    for n, x in enumerate(line):
        if x and n and line[n - 1] == x:
            found[-1] = (found[-1][0], (n + 1) // 2, x)
        elif x:
            found.append((n // 2, (n + 1) // 2, x))
    return found


@pytest.mark.dear("seeds10", "seeds11", "seeds9")
@pytest.mark.few(4)
@pytest.mark.parametrize("seeds", [range(n, n + 25) for n in range(0, 300, 25)])
def test_what_is_claimed_of_a_band_is_what_signs_at_and_between_zeros_say(seeds: range) -> None:
    for own in map(Drawn, seeds):
        made, places = own.chart(), own.places
        curves = {name: chart.SignRow(x, made) for name, x in own.told.items()}
        if any(not own.told[f"{x}.real"].number for x in ("environment", "perceived")) and any(
            own.value("excess.real", x) == 1 for x in own.between
        ):
            continue  # a real part that is zero everywhere has the other's name; both have none
        found = chart.claimed(curves, from_0=made.from_0)

        def holding(test: Any, *names: str, own: Drawn = own) -> list[list[int]]:
            every = [x for pair in zip(own.places, [*own.between, own.places[0]], strict=True) for x in pair][:-1]
            return [[a, b] for a, b, _ in merged([all(test(own.limit(name, x)) for name in names) for x in every])]

        assert found["transparent"] == holding(lambda x: x <= 0, "excess.real", "excess.imag")
        assert found["outside_model"] == holding(lambda x: x < 0, "perceived.imag")
        poles = [i for i, x in enumerate(places) if any(own.order(f"excess.{part}", x) < 0 for part in PARTS)]
        assert found["unbounded"] == poles
        for name in ("environment", "perceived"):
            turning = [i for i, x in enumerate(places) if {*own.around(f"{name}.real", x)} == {1, -1}]
            assert found["changeovers"][name] == turning
        crossings = []
        for (i, x), part in product(enumerate(places), PARTS):
            name = f"excess.{part}"
            if (order := own.order(name, x)) > 0 and own.told[name].number:
                before, after = own.around(name, x)
                from_rest = x == 0 and after > 0
                kind = "touches" if before == after and not from_rest else "exceeds" if after > 0 else "returns"
                change = own.around(f"difference.{part}", x)[1]
                crossings.append({"at": i, "part": part, "kind": kind, "sign": change, "multiplicity": order})
        assert found["crossings"] == crossings
        felt = []
        for part in PARTS:
            line: list[Any] = []
            for x, y in zip(places, [*own.between, None], strict=True):
                now = own.percept(part, y) if y is not None else None
                line += [now if line and now == line[-1] and own.limit(f"excess.{part}", x) > 0 else None, now]
            felt += [
                {"part": part, "from": a, "to": b, "property": name, "change": word}
                for a, b, (name, word) in merged(line[:-1])
            ]
        assert found["percepts"] == felt


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_chart_whose_cells_or_enclosures_do_not_hold_is_refused(seed: int) -> None:
    own = next(x for n in range(100 * seed, 100 * seed + 99) if len((x := Drawn(n)).inside) > 1 and x.low)
    points, told, a = own.points, own.enclosures, own.inside[0]
    fails = partial(refused, chart.PlaceTable, band(1, 6))
    near, far = Fraction(1, 90), Fraction(1, 70)
    for cells, places in (
        (points, told),
        (points, [told[0], [a, a + near], *told[2:]]),
        (points, [told[0], [a - near, a], *told[2:]]),
        (points, [[Fraction(1, 2), Fraction(1)], *told[1:-1], [Fraction(6), Fraction(7)]]),
    ):
        assert not fails(cells, own.factors, places)
    for cells, places in (
        ([*points[:2], *points[3:]], told),  # two zeros in a cell
        ([*points[:1], a, *points[1:]], told),  # a zero at a breakpoint
        ([Fraction(11, 10), *points[1:]], told),
        ([*points[:-1], Fraction(59, 10)], told),
        (points, told[:-1]),
        (points, [*told, told[-1]]),
        (points, [told[0], *told[2:], told[-1]]),
        *((points, [told[0], x, *told[2:]]) for x in ([a + near, a + far], [a - far, a - near], [points[0], a], [a, points[1]], [a + far, a - far])),
        (points, [[Fraction(101, 100)] * 2, *told[1:]]),
        (points, [*told[:-1], [Fraction(599, 100)] * 2]),
    ):  # fmt: skip
        assert fails(cells, own.factors, places)
    assert all(refused(chart.PlaceTable, band(6, x), points, own.factors, told) for x in (6, 1))


def test_a_cell_of_an_end_of_the_band_holds_no_zero() -> None:
    two, other = OmegaFactor(expanded([(-2, 1), (-5, 1)])), OmegaFactor([[9], [0], [1]])
    inner, ends = ([[Fraction(n)] * 2 for n in row] for row in ((1, 2, 5, 6), (1, 6)))

    def fails(points: str, factors: list[OmegaFactor], told: Any) -> bool:
        return refused(chart.PlaceTable, band(1, 6), list(map(Fraction, points.split())), factors, told)

    for points in ("1 3 6", "1/2 3/2 3 11/2 7", "1 3 11/2 7", "1/2 3/2 3 6"):
        assert not fails(points, [two], inner)
    for points in (
        "1/2 3 6",
        "1 3 7",
        "1 6",
        "1 2 6",
        "1 5 6",
        "-1/2 3/2 3 6",
        "1/2 3/4 3/2 3 6",
        "1/2 3/4 1 3 6",
        "1 3 13/2 7",
        "1/4 1/2 3 6",
    ):
        assert fails(points, [two], inner), points
    assert [fails(x, [other], ends) for x in ("1 13/2 7", "1/4 1/2 6", "1/2 7", "1 6")] == [True, True, False, False]
    for own, zero in ((OmegaFactor(expanded([(-1, 2)])), "1/2 6"), (OmegaFactor(expanded([(-7, 1)])), "1 7")):
        for factors in ([own, other], [other, own], [own]):  # nor at its outer end
            for points, fits in ((zero, False), ("1 6", True), ("3/4 6", True), ("1 27/4", True), ("2/3 20/3", True)):
                assert fails(points, factors, ends) is not fits


def test_the_ends_of_a_band_in_hertz_lie_between_those_with_numbers_below_and_above_pi() -> None:
    scene = SceneFile(f'{ENVIRONMENT}[evaluation]\nband = ["1 Hz", "3 Hz"]\n'.encode(), None)
    low, high = (Fraction(*x) for x in PI)
    assert chart.ends_of_band(scene) == [[2 * low, 2 * high], [6 * low, 6 * high]]
    assert exact(low) < MP.pi < exact(high)
    assert high - low < Fraction(1, 10**98)
    assert not refused(
        chart.PlaceTable, scene, [Fraction(6), Fraction(19)], [], [[2 * low, 2 * high], [6 * low, 6 * high]]
    )
    assert refused(chart.PlaceTable, scene, [Fraction(6), Fraction(19)], [], [[2 * low, 2 * low], [6 * low, 6 * high]])
    assert [chart.away(Fraction(n, 2)) for n in range(-3, 4)] == [-2, -1, -1, 0, 1, 1, 2]


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_factors_have_the_zeros_that_they_were_made_of(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(30):
        step, side = draw.choice([1, 2]), draw.choice([-1, 1])
        roots = {
            Fraction(draw.randint(0, 6), draw.choice([1, 2])): draw.choice([1, 1, 2]) for _ in range(draw.randint(0, 4))
        }
        a, b = sorted(draw.sample([Fraction(n, 2) for n in range(13)], 2))
        rows = expanded([((-(x**step)).numerator, (x**step).denominator) for x, n in roots.items() for _ in range(n)])
        factor = OmegaFactor([[side * c for c in row] for row in rows], step)

        def value(x: Fraction, rows: Any = rows, step: int = step, side: int = side) -> int:
            return side * sign(sum(c * x ** (step * i) for i, (c,) in enumerate(rows)))

        order, found = factor.signs(a, b)
        assert order == roots.get(a, 0) * (step if a == 0 else 1)
        assert found[0] == value(min([x for x in (*roots, b) if x > a]) / 2 + a / 2)
        turns = [x for x in found if x]
        assert sum(x != y for x, y in pairwise(turns)) == sum(n for x, n in roots.items() if a < x < b)
        assert len(found) - 1 - max(i for i, x in enumerate(found) if x) == roots.get(b, 0)
        x = Fraction(draw.randint(0, 12), 4)
        assert factor.sign(x) == value(x)


def test_signs_that_depend_on_pi_stay_open_where_its_bounds_do_not_tell() -> None:
    assert OmegaFactor([[-314159265358979323846, 10**20]]).sign(Fraction(1)) == 1
    assert OmegaFactor([[0, 1], [-1]]).signs(Fraction(3), Fraction(4)) == (0, [1, -1])
    for digits, is_open in ((99, False), (130, True)):
        near = OmegaFactor([[-int(MP.pi * 10**digits), 10**digits]])
        assert refused(near.sign, Fraction(1)) is is_open


# Rule 5: zeros in Re s >= 0


def test_an_even_part_may_vanish_in_the_last_cell_and_zeros_at_0_count() -> None:
    """(s + 2) (s^2 - s + 3) and (s + 3) (s^2 - 2 s + 5): E = 6 - W and O = 1 - W, E = 15 - W and O = -1 - W."""
    for p, cuts in (([6, 1, 1, 1], "0 2"), ([15, -1, 1, 1], "0"), ([15, -1, 1, 1], "0 9"), ([15, -1, 1, 1], "0 20")):
        for side, more in product((1, -1), (0, 1)):
            rows = [*[[0]] * more, *([side * c] for c in p)]
            assert chart.to_the_right(rows, list(map(Fraction, cuts.split()))) == 2 + more


def test_cells_that_do_not_part_zeros_of_even_and_odd_parts_are_refused() -> None:
    rows = expanded([(1, 1), (2, 1), (3, 1), (4, 1)])  # E = W^2 - 35 W + 24, O = 50 - 10 W
    assert chart.to_the_right(rows, list(map(Fraction, (0, 1, 20)))) == 0
    for cuts in ((0,), (0, 40), (0, 1), (0, 4, 40)):
        assert refused(chart.to_the_right, rows, list(map(Fraction, cuts)))
    assert refused(chart.to_the_right, [[6], [1], [1]], list(map(Fraction, (0, 6))))  # E = 6 - W is zero there
    assert not refused(chart.to_the_right, [[6], [1], [1]], list(map(Fraction, (0, 5))))


@pytest.mark.parametrize("seed", range(4))
def test_polynomials_have_a_zero_in_common_if_they_share_one(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(30):
        p, q = ([(draw.randint(-6, 6), draw.randint(1, 3)) for _ in range(draw.randint(0, 4))] for _ in range(2))
        shared = {Fraction(-a, b) for a, b in p} & {Fraction(-a, b) for a, b in q}
        assert chart.coprime(expanded(p), expanded(q)) == (not shared)
    with_pi, lost = [[0, 1], [1]], [[1], [chart.PRIME]]  # nothing is known where a leading coefficient vanishes
    assert chart.coprime(with_pi, [[0, 2], [3]])
    assert not chart.coprime(with_pi, [[0, 0, 1], [0, 2], [1]])
    for p in ([[1]], [[2], [1]], [[3], [5], [1]], lost):
        assert not chart.coprime(lost, p)
        assert not chart.coprime(p, lost)


def test_zeros_are_counted_with_multiplicity_and_poles_left_out() -> None:
    factors = [[["-1"], ["1"]], [["2"], ["1"]], [["3"], ["1"]]]
    told: dict[str, Any] = {
        "factors": factors,
        "function": {"number": "1", "powers": [[0, 3], [1, 1], [2, -1]]},
        "cells": [[]] * 3,
    }

    def function(point: ChainPoint, power: int = 3) -> Ratio:
        """(s - 1)^3 (s + 2)/(s + 3)."""
        one, two, three = (combined("+", point.s, (GaussianValue(n), ONE)) for n in (-1, 2, 3))
        return combined("/", reduce(partial(combined, "*"), [one] * power, two), three)

    def count(power: int = 3, **other: Any) -> int:
        return chart.zeros(told | other, partial(function, power=power), 20)

    assert count() == 3
    assert count(2, function={"number": "1", "powers": [[0, 2], [1, 1], [2, -1]]}) == 2
    assert refused(count, cells=[[], []])
    for number, powers in (
        ("1", [[0, 2], [1, 1], [2, -1]]),
        ("1", [[0, 3], [1, 1]]),
        ("2", told["function"]["powers"]),
    ):
        assert refused(count, function={"number": number, "powers": powers})
    shared = {"number": "1", "powers": [[0, 3], [1, 1], [2, -1], [3, -1]]}  # (s - 1)^3/(s - 1)
    assert refused(count, 2, factors=[*factors, factors[0]], function=shared, cells=[[]] * 4)
    nothing = {"factors": [], "function": {"number": "0", "powers": []}, "cells": []}
    assert refused(chart.zeros, nothing, lambda _: (GaussianValue(0), ONE), 20)


# Rule 6: slabs of values


def slab(low: str | None, high: str | None, points: list[str], part: str | None = None) -> dict[str, Any]:
    return {"from": low, "to": high, "points": points, "part": part}


def test_values_of_a_requirement_follow_from_their_slabs() -> None:
    """excess = (omega^2 - 3 + p) p, of p in place of pi: on the band from 0 to 1 positive where p > 3, or p < 0 and omega^2 < 3 - p; and omega - 9."""
    factors = [OmegaFactor([[-3, 1], [1]], 2), OmegaFactor([[0, 1]]), OmegaFactor([[-9], [1]])]
    whole = {"excess.real": [[0, 1], [1, 1]], "excess.imag": [[2, 1]]}

    def found(*slabs: dict[str, Any], number: str = "1", powers: Any = None) -> Any:
        named = whole if powers is None else {"excess.real": powers}
        told = {name: FactoredNumber({"number": number, "powers": x}, factors) for name, x in named.items()}
        return requirement.values(told, factors, list(slabs), band(0, 1))

    below, good, above = slab(None, "0", ["1/2"], "real"), slab("0", "2", ["0", "1"]), slab("3", None, ["1/2"], "real")
    assert found(below, good, above) == [[[None, "0", False], ["0", "2", True], ["3", None, False]], ["real", "real"]]
    assert found(below) == [[[None, "0", False]], []]
    assert found(slab("0", "1", ["0", "1"]), slab("1", "2", ["0", "1/2", "1"])) == [[["0", "2", True]], []]
    high = slab("3", "4", ["1/2"], "real"), slab("4", None, ["3/4"], "real")
    assert found(*high) == [[["3", None, False]], []]
    assert found(good, *high)[1] == ["real"]
    assert found(slab("3", "4", ["0"], "real"))[0] == [["3", "4", False]]  # p (p - 3) > 0 inside alone
    for wrong in (
        [above, good], [good, good], [slab("0", "1", ["0", "1"]), slab("3/2", "2", ["0", "1"])], [slab("2", "0", ["0", "1"])],
        [slab("0", "0", ["0", "1"])], [slab("0", "2", ["0", "1/2"])], [slab("0", "2", ["1/2", "1"])], [slab("0", "2", ["-1", "1"])],
        [slab("3", None, ["2"], "real")], [slab("3", None, ["1/2", "3/4"], "real")], [slab("3", None, ["1/2"], "imag")], [slab("1", "4", ["0", "1"])],
        [slab("0", "2", ["1/2"], "real")], [slab("3", None, ["0", "1"])], [slab("-1", "2", ["0", "1"])], [slab("2", "3", ["0"], "real")],
        [slab("0", "2", ["0", "1"]), slab(None, "3", ["0", "1"])], [slab("2", "3", ["0", "1"]), slab("3", "5", ["0"], "real"), slab("4", None, ["1/2"], "real")],
    ):  # fmt: skip
        assert refused(found, *wrong), wrong
    nothing = {"number": "0", "powers": []}  # it does not exceed its threshold
    assert found(slab("0", "2", ["0", "1"]), **nothing) == [[["0", "2", True]], []]
    assert refused(found, slab("0", "2", ["1/2"], "real"), **nothing)
    assert refused(found, slab("3", None, ["1/2"], "imag"), powers=whole["excess.real"])  # no claim about that part
    assert refused(found, slab("1", "4", ["0"], "real"), powers=[[0, 2], [1, 1]])
    assert not refused(found, slab("3", "4", ["0", "1"]), slab("4", "5", ["0", "1"]), number="-1", powers=[[0, -1]])
    assert refused(found, slab("2", "3", ["0"], "real"), slab("3", "4", ["0"], "real"), number="-1", powers=[[0, -1]])


def test_where_two_slabs_join_an_excess_may_vanish_but_has_no_pole_and_a_part_exceeds_there_too() -> None:
    """-(p - 1)^2 and -1/(p - 1)^2, of p in place of pi, at the end p = 1 of two slabs; 1/(p - 4)^2 and its root below 4."""
    factors = [OmegaFactor([[-1, 1]]), OmegaFactor([[-4, 1]])]
    cells = slab("0", "1", ["0", "1"]), slab("1", "2", ["0", "1/2", "1"])
    points = slab("0", "1", ["1/2"], "real"), slab("1", "2", ["3/4"], "real")

    def accepted(slabs: Any, number: int, *powers: tuple[int, int]) -> bool:
        told = {"excess.real": FactoredNumber({"number": f"{number}/3", "powers": [list(x) for x in powers]}, factors)}
        return not refused(requirement.values, told, factors, list(slabs), band(0, 1))

    for slabs, number in ((cells, -1), (points, 1)):
        for n, both in ((2, number < 0), (-2, False)):
            assert accepted(slabs, number, (0, n)) is both
            assert all(accepted([one], number, (0, n)) for one in slabs)
            assert not any(accepted(x, -number, (0, n)) for x in (slabs, slabs[:1], slabs[1:]))
        for n, fits in ((1, -1), (3, -1), (-1, -1), (2, 1), (-2, 1), (4, 1)):
            assert accepted(slabs, fits * number, (1, n))
            assert not accepted(slabs, -fits * number, (1, n))


def test_an_end_belongs_to_a_slab_where_a_factor_is_not_zero_there() -> None:
    """p - 1 above 1 and below it."""
    for low, high, fits in (((1, 1), (2, 1), (False, True)), ((0, 1), (1, 1), (True, False))):
        made = requirement.Slices(OmegaFactor([[-1, 1]]), low, high)
        assert made.side(Fraction(0), Fraction(1), fits) == (1 if low == (1, 1) else -1)
        assert refused(made.side, Fraction(0), Fraction(1), fits[::-1])


@pytest.mark.dear("0-True", "1-False")
@pytest.mark.parametrize(
    ("seed", "waved"), often([(n, w) for w in (False, True) for n in range(6)], lambda x: x[0] < 2 - x[1])
)
def test_the_slices_of_a_factor_have_the_sign_of_all_its_values(seed: int, waved: bool) -> None:  # noqa: FBT001
    """Against its values in mpmath at values and frequencies between, ends of the slab and omega = 0 among them."""
    draw, told = random.Random(seed), 0
    for _ in range(20 if waved else 30):
        delays = tuple(Fraction(n, 7) for n in draw.sample(range(1, 9), draw.randint(0, 2) * waved))
        orders = tuple(Fraction(n, 10) for n in draw.sample(range(1, 10), draw.randint(not delays, 1) * waved))
        factor, value = wave_factor(draw, delays, orders, constant=draw.choice([0, 30, -30]))
        first = draw.choice([None, Fraction(draw.randint(-4, 4), 2)])
        last = None if first is not None and draw.random() < 0.3 else (first or 0) + Fraction(draw.randint(1, 8), 8)
        a = draw.choice([Fraction(0), Fraction(draw.randint(1, 20), 10)])
        b = a + draw.choice([0, Fraction(1, 50), Fraction(1, 2)])
        closed = draw.random() < 0.5 and first is not None, draw.random() < 0.5 and last is not None
        low, high = (
            (-1, 0) if first is None else first.as_integer_ratio(),
            (1, 0) if last is None else last.as_integer_ratio(),
        )
        try:
            found = requirement.Slices(factor, low, high).side(a, b, closed)
        except RefusedError:
            continue
        told += 1
        start = first if first is not None else (last or 0) - 50
        end = last if last is not None else start + 50
        for u, v in product(range(0 if closed[0] else 1, 6 if closed[1] else 5), range(1, 4)):
            assert found * value(exact(a + (b - a) * Fraction(v, 4)), exact(start + (end - start) * Fraction(u, 5))) > 0
    assert told > 2


# Rules 7 and 8: sines, cosines and powers


def wave_factor(
    draw: random.Random, delays: tuple[Fraction, ...], orders: tuple[Fraction, ...], constant: int = 0
) -> tuple[Any, Any]:
    """A random one, and its value in mpmath, with pi unless a value takes its place; ``constant`` is added to one term."""
    most = [draw.randint(0, 2) for _ in delays]
    rows: dict[tuple[int, ...], list[list[int]]] = {}
    for _ in range(draw.randint(1, 4) if delays or orders else 1):
        turns = tuple(draw.randint(0, k) for k in most) + tuple(draw.randint(0, 2) for _ in range(2 * len(orders)))
        p = [[draw.randint(-9, 9) for _ in range(draw.randint(1, 2))] for _ in range(draw.randint(1, 3))]
        p[-1][-1] = draw.choice([-3, 2])
        p[0][0] += 0 if rows else constant
        rows[turns] = p
    told = {"waves": most, "terms": [[list(k), [[str(c) for c in row] for row in p]] for k, p in rows.items()]}

    def value(w: Any, q: Any = MP.pi) -> Any:
        total = MP.mpf(0)
        for turns, p in rows.items():
            term = MP.fsum(MP.fsum(c * q**k for k, c in enumerate(row)) * w**n for n, row in enumerate(p))
            for tau, k, m in zip(delays, turns, most, strict=False):
                term *= MP.sin(w * exact(tau) / 2) ** k * MP.cos(w * exact(tau) / 2) ** (m - k)
            for i, alpha in enumerate(orders):
                k, m = turns[len(delays) + 2 * i :][:2]
                turned = MP.expjpi(exact(alpha) / 2) * w ** exact(alpha)
                term *= turned.real**k * turned.imag**m
            total += term
        return total

    if not delays and not orders:
        return OmegaFactor(rows[()]), value
    return delayterms.WaveFactor(told, delays, orders), value


def drawn_waves(draw: random.Random, least: int = 0) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """Delays and orders."""
    delays = tuple(Fraction(n, 7) for n in draw.sample(range(1, 9), draw.randint(least, 2)))
    return delays, tuple(Fraction(n, 10) for n in draw.sample(range(1, 10), draw.randint(not delays, 1)))


@pytest.mark.dear("6")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_taylors_sums_hold_a_factor_with_waves_and_its_signs_are_those_of_mpmath(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(3):
        factor, value = wave_factor(draw, *drawn_waves(draw))
        a = Fraction(draw.randint(8, 30), 4)
        b = a + Fraction(1, draw.choice([4, 8, 30]))
        row, lost = factor.model(factor.all, a, b)
        half = exact(b - a) / 2
        for n in (-6, -1, 0, 5, 6):
            v, at_v = MP.mpf(n) / 6, exact((a + b) / 2 + (b - a) * Fraction(n, 12))
            true, most = value(at_v), MP.mpf(lost) / SCALE
            assert abs(MP.fsum(c * v**i for i, c in enumerate(row)) / SCALE - true) <= most < 1e-6 * (1 + abs(true))
            slope = MP.fsum(i * c * v ** (i - 1) for i, c in enumerate(row) if i) / SCALE
            assert abs(slope - MP.diff(value, at_v) * half) <= ORDER * most + 1e-40
        if abs(value(exact(a))) > 1e-9:
            assert factor.sign(a) == sign(value(exact(a)))
        every = [sign(value(exact(a + (b - a) * n / 12))) for n in range(13)]
        try:
            found = factor.signs(a, b)
        except RefusedError:
            continue
        assert found == (0, every[:1] if len(found[1]) == 1 else [every[0], every[-1]])
        assert len(found[1]) == 2 or len({*every}) == 1


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_factors_with_waves_begin_at_0_with_the_power_that_mpmath_sees(seed: int) -> None:
    draw = random.Random(seed)
    for cancels in (False, True, False, True):
        delays, orders = drawn_waves(draw, 1)
        factor, value = beginning(draw, delays[0]) if cancels else wave_factor(draw, delays, orders)
        order, found = factor.signs(Fraction(0), Fraction(1, 10**6))
        tiny = MP.mpf(10) ** -40, MP.mpf(10) ** -42
        slope = (MP.log(abs(value(tiny[0]))) - MP.log(abs(value(tiny[1])))) / MP.log(100)
        assert abs(slope - exact(order)) < 1e-3
        assert found == [sign(value(tiny[1]))]
        if not refused(factor.signs, Fraction(0), Fraction(1, 20)):
            assert factor.signs(Fraction(0), Fraction(1, 20)) == (order, found)
            assert all(sign(value(MP.mpf(n) / 200)) == found[0] for n in range(1, 11))


def beginning(draw: random.Random, tau: Fraction) -> tuple[delayterms.WaveFactor, Any]:
    """pi (sin x - x cos x) + c omega^n cos x, x = omega tau/2: it begins with x^3 or with omega^n."""
    c, n, (p, q) = draw.choice([-2, 3]), draw.choice([2, 3, 5]), tau.as_integer_ratio()
    cosine = [["0"], ["0", str(-p)], *([["0"]] * (n - 2)), [str(c)]]
    told = {"waves": [1], "terms": [[[1], [["0", str(2 * q)]]], [[0], cosine]]}

    def value(w: Any) -> Any:
        x = w * p / (2 * q)
        return 2 * q * MP.pi * (MP.sin(x) - x * MP.cos(x)) + c * w**n * MP.cos(x)

    return delayterms.WaveFactor(told, (tau,)), value


def test_cells_that_may_hold_more_than_one_zero_of_a_wave_are_refused() -> None:
    def times_cosine(*p: int) -> delayterms.WaveFactor:
        return delayterms.WaveFactor({"waves": [1], "terms": [[[0], [[str(c)] for c in p]]]}, (Fraction(2),))

    sine = delayterms.WaveFactor({"waves": [1], "terms": [[[1], [["1"]]]]}, (Fraction(2),))  # sin omega
    raised = delayterms.WaveFactor(
        {"waves": [], "terms": [[[1, 0], [["1"]]], [[0, 0], [["-1"]]]]}, (), (Fraction(1, 2),)
    )
    for factor, a, b, found in (
        (sine, "3", "33/10", (0, [1, -1])), (sine, "4", "5", (0, [-1])), (sine, "3", "19/2", None), (sine, "0", "7/2", None), (sine, "0", "1", (1, [1])),
        (times_cosine(-5, 1), "49/10", "51/10", (0, [-1, 1])), (times_cosine(-5, 1), "49/10", "5", None), (times_cosine(-5, 1), "5", "51/10", None),
        (times_cosine(2525, -1005, 100), "49/10", "51/10", None), (times_cosine(25, -10, 1), "49/10", "51/10", None),  # two, and one of order two
        (times_cosine(-1, 100), "0", "1/50", None), (times_cosine(-1, 50), "0", "1/100", (0, [-1])),
        (raised, "0", "4", None), (raised, "0", "1", (0, [-1])), (raised, "19/10", "21/10", (0, [-1, 1])),  # sqrt(omega/2) - 1
    ):  # fmt: skip
        cell = Fraction(a), Fraction(b)
        assert (None if refused(factor.signs, *cell) else factor.signs(*cell)) == found, cell


def test_sides_are_those_of_bernsteins_coefficients_beyond_what_is_lost() -> None:
    assert (delayterms.strict(5, 4), delayterms.strict(-5, 4)) == (1, -1)
    assert refused(delayterms.strict, 5, 5)
    assert refused(delayterms.strict, -5, 5)
    for row, lost, found in (
        ([5, 0], 4, 1), ([9, 4], 4, 1), ([1], 0, 1), ([-5, 0], 4, -1), ([-9, 4], 4, -1), ([8, 4], 4, 0), ([8, -4], 4, 0), ([-8, 4], 4, 0), ([1], 1, 0),
        ([2, 0, -1], 0, 1), ([5, 0, 2], 2, 1), ([5, 0, 2], 3, 0), ([0, 0, 1], 0, 0), ([1, 0, -1], 0, 0), ([1, 0, 2], 0, 0),
    ):  # fmt: skip
        assert delayterms.side(row, lost) == found, row


def test_what_a_model_is_off_by_is_bounded_where_hardly_anything_is_given_away() -> None:
    """A cosine from 0 on, whose sizes are those at 0 and not at the end; a power at the low end of its cell."""
    cosine = delayterms.WaveFactor({"waves": [1], "terms": [[[0], [["1"]]]]}, (Fraction(1),))
    power = delayterms.WaveFactor({"waves": [], "terms": [[[1, 0], [["1"]]]]}, (), (Fraction(1, 2),))
    for factor, a, b, v, true in (
        (cosine, Fraction(0), Fraction(3), 1, MP.cos(MP.mpf(3) / 2)), (power, Fraction(1), Fraction(3, 2), -1, MP.cos(MP.pi / 4)),
    ):  # fmt: skip
        row, lost = factor.model(factor.all, a, b)
        off = abs(sum(c * v**n for n, c in enumerate(row)) - true * SCALE)
        assert off <= lost < 100 * off


def test_a_factor_with_waves_has_its_size_and_every_term_once() -> None:
    delays, orders, term = (Fraction(1, 3),), (Fraction(1, 2),), [[1, 0, 2], [["1", "2"], ["-3"]]]
    assert delayterms.WaveFactor({"waves": [1], "terms": [term]}, delays, orders).degrees == (1, 1, 1, 2, 0, 0)
    assert not refused(delayterms.WaveFactor, {"waves": [40], "terms": [[[40, 0, 40], [["1"]]]]}, delays, orders)
    many = [[list(x), [["1"]]] for x in product(range(8), repeat=3)]
    assert not refused(delayterms.WaveFactor, {"waves": [7], "terms": many[:300]}, delays, orders)
    for wrong in ({"waves": [41], "terms": [term]}, {"waves": [1], "terms": [term, term]}, {"waves": [0], "terms": [term]}, {"waves": [1], "terms": []},
                  {"waves": [], "terms": [term]}, {"waves": [1], "terms": [[[1, 0], [["1"]]]]}, {"waves": [1], "terms": [[[1, 0, 41], [["1"]]]]},
                  {"waves": [1], "terms": [[[1, 0, -1], [["1"]]]]}, {"waves": [7], "terms": many[:301]}):  # fmt: skip
        assert refused(delayterms.WaveFactor, wrong, delays, orders)


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_sines_and_powers_are_those_of_mpmath_and_of_arb(seed: int) -> None:
    draw = random.Random(seed)
    large = Fraction(draw.randint(1, 10**40), draw.randint(10**26, 10**27))
    for x in (
        Fraction(0),
        Fraction(1, 2),
        large,
        *(Fraction(draw.randint(0, 999), draw.choice([1, 7, 360])) for _ in range(12)),
    ):
        c, s = MP.cos(exact(x)), MP.sin(exact(x))
        assert all(abs(true * SCALE - own) < 2 for own, true in zip(delayterms.circle(x), (c, -s, -c, s), strict=True))
    for x in (
        Fraction(1),
        Fraction(2),
        Fraction(3, 10**300),
        Fraction(10**300),
        *(Fraction(draw.randint(1, 10**9), draw.randint(1, 10**9)) for _ in range(12)),
    ):
        alpha = draw.choice([Fraction(draw.randint(1, 29), 30), Fraction(1, 2**99 + 1)])
        m, r = delayterms.power(x, alpha)
        with flint.ctx.workprec(3000):
            true = flint.arb(flint.fmpq(x.numerator, x.denominator)) ** flint.arb(
                flint.fmpq(alpha.numerator, alpha.denominator)
            )
            assert abs(true * SCALE - m) <= r
            assert r <= 2 + 2 * true
    half, most = Fraction(1, 2), Fraction(2) ** 99_999
    assert [refused(delayterms.circle, x) for x in (Fraction(2**48), Fraction(2**48 - 1))] == [True, False]
    for x, too_large in (
        (Fraction(0), True),
        (Fraction(-1), True),
        (most, False),
        (1 / most, False),
        (2 * most, True),
        (1 / (2 * most), True),
    ):
        assert refused(delayterms.power, x, half) == too_large


@pytest.mark.parametrize("seed", SEEDS)
def test_the_series_of_a_power_is_off_by_no_more_than_it_says_and_over_a_cell_has_the_largest_sizes(seed: int) -> None:
    draw = random.Random(seed)
    alpha, low = Fraction(draw.randint(1, 99), 100), Fraction(draw.randint(1, 999), draw.choice([1, 7, 36]))
    step = low * Fraction(draw.randint(1, 60), draw.choice([100, 1000]))

    def coefficients(x: Fraction) -> list[Any]:
        a = exact(alpha)
        return [MP.binomial(a, n) * exact(x) ** (a - n) * exact(step) ** n for n in range(ORDER + 1)]

    row, lost = delayterms.binomial(alpha, low, low, step, ORDER + 1)
    assert sum(abs(own - true * SCALE) for own, true in zip(row, coefficients(low), strict=True)) <= lost < 100
    sizes, lost = delayterms.binomial(alpha, low, low + 2 * step, step, ORDER + 1)
    for x in (low, low + step, low + 2 * step):
        beyond = (abs(true) * SCALE - own for own, true in zip(sizes, coefficients(x), strict=True))
        assert sum(max(0, off) for off in beyond) <= lost


@pytest.mark.parametrize(
    ("kind", "dimension", "words"),
    [
        ("k", Dimension.STIFFNESS, "Nm/rad N-m/rad N.m/rad Nm/deg mNm/deg N/mm lbf/in lbf-in/deg Nmm/rad Nms mN"),
        ("b", Dimension.DAMPING, "Nms/rad Ns/m N-s/m Nsm-1 Nms/deg Nm/(rad/s) kNms/rad N/m"),
        ("m", Dimension.MASS, "kgm^2 kg.m2 kgm2 kg-m^2 gcm^2 kg kgmm"),
    ],
)
def test_units_that_are_run_together_mean_the_same_to_the_checker(kind: str, dimension: Dimension, words: str) -> None:
    for text in (f"{number} {unit}" for unit in words.split() for number in ("1.5e3", "2/3")):
        said = refusal(read_quantity, text, dimension)
        if said:
            with pytest.raises(RefusedError):
                checked_quantity(text, kind)
            continue
        mine, other = read_quantity(text, dimension).value, checked_quantity(text, kind)
        assert mine == Rational(other.value.numerator, other.value.denominator) * pi**other.pi, text
