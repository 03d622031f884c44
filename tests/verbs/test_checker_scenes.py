"""What the checker of certificates takes for a scene: tables, keys and numbers one by one, and the dynamics against formulas written a second time."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest
from certificates import CANCELLING

from haptisym_check import RefusedError
from haptisym_check.scene import Scene
from haptisym_check.values import ONE, Point, Value, degree

ENVIRONMENT = '[environment]\nmodel = "kelvin-voigt"\nk = 3\nb = 5\n'
LAG = '[[effects]]\nmodel = "first-order-lag"\nomega_c = 7\n'


def at(text: str, x: int = 2, name: str | None = None, others: tuple[Any, ...] = (), **named: Any) -> list[complex]:
    """H_env and H_perc at s = j x; in place of pi stands 3."""
    delays, orders = named.get("delays", ()), named.get("orders", ())
    scene = Scene(text.encode(), name, named.get("free"))
    found = scene.at(Point((Value(0, x, degree(0)), ONE), 3, delays, orders, others))
    turned = [(top.times(bottom.conjugate()), bottom.times(bottom.conjugate()).re) for top, bottom in found]
    return [complex(Fraction(top.re, size), Fraction(top.im, size)) for top, size in turned]


def refused(text: str, name: str | None = None, **named: Any) -> bool:
    try:
        at(text, name=name, **named)
    except RefusedError:
        return True
    return False


def effect(model: str, *lines: str) -> str:
    return "\n".join([ENVIRONMENT, "[[effects]]", f'model = "{model}"', *lines, ""])


def environment(model: str, *lines: str) -> str:
    return "\n".join(["[environment]", f'model = "{model}"', *lines, ""])


def test_tables_of_a_scene_have_their_shape_and_no_other() -> None:
    good = (
        ENVIRONMENT,
        ENVIRONMENT + LAG,
        f'title = "x"\nsource = "y"\n{ENVIRONMENT}[rendered]\nmodel = "kelvin-voigt"\nk = "environment.k"\nb = 0\n',
        f"{ENVIRONMENT}[evaluation]\nband = [1, 2]\njnd = 0.2\n",
        f"{ENVIRONMENT}[evaluation]\njnd = {{real = 0.1, imag = 0.2}}\n",
        environment("mass-spring-damper"),
        environment("expression", 'H = "a*s"', 'parameters = {a = "3 N/m"}'),
        environment("prony", "k0 = 1", "k = [2, 3]", "b = [4, 5]"),
        effect("shunt", 'Z = "a"', "parameters = {a = 2}"),
        effect("shunt", 'm = "1 kg"'),
    )
    for text in good:
        assert not refused(text), text
    wrong = (
        "", LAG, "environment = 5", "environment = []", '[environment]\nmodel = ["kelvin-voigt"]\nk = 3\nb = 5\n', "[environment]\nk = 3\nb = 5\n",
        ENVIRONMENT + "c = 1\n", environment("kelvin-voigt", "k = 3"), environment("first-order-lag", "omega_c = 7"), environment("no-model"),
        effect("kelvin-voigt", "k = 3", "b = 5"), effect("first-order-lag"), effect("first-order-lag", "omega_c = 7", "parameters = {a = 1}"),
        effect("series", 'G = "1"', "parameters = 5"), effect("series", 'G = "1"', "parameters = [5]"), effect("shunt Z", "m = 1"), effect("shunt", 'Z = "1"', "m = 1"),
        f"colour = 1\n{ENVIRONMENT}", f"effects = 5\n{ENVIRONMENT}", f"effects = [5]\n{ENVIRONMENT}", f"evaluation = 5\n{ENVIRONMENT}",
        f"{ENVIRONMENT}[evaluation]\nfrom = 0\n", f"{ENVIRONMENT}[evaluation]\nband = [1]\n", f"{ENVIRONMENT}[evaluation]\nband = [1, 2, 3]\n",
        f'{ENVIRONMENT}[evaluation]\nband = "12"\n', f"{ENVIRONMENT}[evaluation]\njnd = {{real = 0.1}}\n",
        f"{ENVIRONMENT}[evaluation]\njnd = {{real = 0.1, imag = 0.1, joint = 0.1}}\n",
        f"rendered = 5\n{ENVIRONMENT}", f'{ENVIRONMENT}[rendered]\nmodel = "kelvin-voigt"\nk = "environment.m"\nb = 0\n',
        '[environment]\nmodel = "kelvin-voigt"\nk = "environment.b"\nb = 5\n', f'{ENVIRONMENT}[[effects]]\nmodel = "first-order-lag"\nomega_c = "environment.k"\n',
        f"environments = []\n{ENVIRONMENT}", f"[environments]\n{ENVIRONMENT}",
    )  # fmt: skip
    for text in wrong:
        assert refused(text), text


def test_numbers_of_models_are_in_their_bounds() -> None:
    tau, T = 'tau = "1 ms"', 'T = "1 ms"'
    clock = lambda delay, method='"tustin"': effect("sampled-loop", T, f"delay = {delay}", f"method = {method}")  # noqa: E731
    pade = lambda order: effect("pade-delay", tau, f"order = {order}")  # noqa: E731
    prony = lambda k, b: environment("prony", "k0 = 1", f"k = {k}", f"b = {b}")  # noqa: E731
    delays, others = (Fraction(1, 1000),), (2,)
    for text in (clock(0), clock(20), clock(3, '"backward-difference"'), clock(3, '"forward-difference"')):
        assert not refused(text, delays=delays, others=others)
    for text in (pade(1), pade(10), prony([1], [2]), prony([1] * 20, [2] * 20)):
        assert not refused(text)
    for text in (
        *map(clock, (-1, 21, "true", "1.0", '"1"')),
        *(clock(1, x) for x in ('"zoh"', '["tustin"]', "1")),
        *map(pade, (0, 11, -1, "true", "1.0", '"1"')),
        effect("pade-delay", tau), effect("sampled-loop", T, "delay = 1"),
        prony([], []), prony([1], []), prony([1, 2], [3]), prony(1, [2]), prony([1], 2), prony([1] * 21, [2] * 21), environment("prony", "k0 = 1", "k = [1]"),
    ):  # fmt: skip
        assert refused(text, delays=delays, others=others), text
    for lag, is_refused in (("0", False), ("1 ms", False), ("-1 ms", True), ("1 ms*rev", True), ("1 ms*rad", False)):
        assert refused(effect("delay", f'tau = "{lag}"'), delays=delays, others=others) == is_refused, lag
    for alpha, is_refused in (
        ("1/2", False),
        ("0", True),
        ("1", True),
        ("-1/2", True),
        ("0.5 rev", True),
        ("3/2", True),
    ):
        text = environment("spring-pot", "k_alpha = 2", f'alpha = "{alpha}"')
        assert refused(text, orders=(Fraction(1, 2),), others=((3, 4),)) == is_refused, alpha


def test_of_several_environments_one_is_asked_for_by_its_name_or_its_model() -> None:
    def several(*rows: str) -> str:
        return "\n".join(f"[[environments]]\n{row}\n" for row in rows)

    stiff, soft = 'name = "stiff"\nmodel = "kelvin-voigt"\nk = 3\nb = 5', 'model = "mass-spring-damper"\nk = 2'
    felt = f'{soft}\n[environments.rendered]\nmodel = "kelvin-voigt"\nk = "environment.k"\nb = 1'
    assert at(several(stiff, soft), name="stiff") == [3 + 10j] * 2
    assert at(several(stiff, soft), name="mass-spring-damper") == [2] * 2
    assert at(several(stiff, felt), name="mass-spring-damper") == [2, 2 + 2j]
    assert at(several(stiff, soft) + LAG, name="stiff")[0] == 3 + 10j
    for text, name in (
        (several(stiff, soft), None), (several(stiff, soft), "kelvin-voigt"), (several(stiff, soft), "hard"), (several(stiff, stiff), "stiff"),
        (several(stiff, soft) + ENVIRONMENT, "stiff"), (several(stiff) + '[rendered]\nmodel = "kelvin-voigt"\nk = 1\nb = 1\n', "stiff"),
        (ENVIRONMENT, "kelvin-voigt"), ("environments = 5", "stiff"), ("environments = [5]", "stiff"), ("environments = [{}]", "stiff"),
    ):  # fmt: skip
        assert refused(text, name), (text, name)


def test_bands_and_thresholds_are_those_of_the_file_and_else_what_they_are_if_nothing_is_said() -> None:
    def told(evaluation: str) -> tuple[list[tuple[Fraction, int]], list[tuple[Fraction, int]]]:
        scene = Scene(f"{ENVIRONMENT}{evaluation}".encode(), None)
        return [(x.value, x.pi) for x in scene.band], [
            (scene.threshold[x].value, scene.threshold[x].pi) for x in ("real", "imag")
        ]

    tenth = (Fraction(1, 10), 0)
    assert told("") == told("[evaluation]\n") == ([(0, 0), (15, 0)], [tenth, tenth])
    assert told('[evaluation]\nband = ["10 rad/s", 20]\n') == ([(10, 0), (20, 0)], [tenth, tenth])
    assert told('[evaluation]\nband = [1_0.5, "10 Hz"]\n') == ([(Fraction(21, 2), 0), (20, 1)], [tenth, tenth])
    assert told('[evaluation]\njnd = "20 %"\n')[1] == [(Fraction(1, 5), 0)] * 2
    assert told("[evaluation]\njnd = {imag = 0.25, real = 1}\n")[1] == [(1, 0), (Fraction(1, 4), 0)]


def test_a_hand_is_the_one_of_that_name() -> None:
    def hand(hands: str, name: str) -> dict[str, Any]:
        return Scene(f"{ENVIRONMENT}{hands}".encode(), None).hand(name)

    two = '[[hands]]\nname = "a"\nm = 1\nsource = "x"\n[[hands]]\nname = "b"\nm = 2\nk = 3\n'
    assert (hand(two, "a"), hand(two, "b")) == ({"m": 1}, {"m": 2, "k": 3})
    assert hand("[hand]\nm = 4\n", "hand") == hand("[[hands]]\nm = 4\n", "hand") == {"m": 4}
    assert hand('[hand]\nname = "own"\nm = 4\n', "own") == {"m": 4}
    for hands, name in (
        ("", "hand"), (two, "c"), (two, "hand"), ('[hand]\nname = "own"\nm = 4\n', "hand"), ('[[hands]]\nname = "a"\n[[hands]]\nname = "a"\n', "a"),
        ('[hand]\nmodel = "expression"\nH = "s"\n', "hand"), ("hand = 5\n", "hand"),
    ):  # fmt: skip
        with pytest.raises(RefusedError):
            hand(hands, name)


def test_a_number_is_left_free_where_its_path_leads_and_pi_is_nowhere_else() -> None:
    text = f"{ENVIRONMENT}{LAG}"
    assert at(text, free=["environment", "k"]) == pytest.approx([3 + 10j, (3 + 10j) * 7 / (7 + 2j)])  # 3 stands for it
    assert at(text, free=["effects", 0, "omega_c"])[1] == pytest.approx((3 + 10j) * 3 / (3 + 2j))
    threshold = Scene(f"{text}[evaluation]\njnd = 0.2\n".encode(), None, ["evaluation", "jnd"]).threshold
    assert threshold["real"] is threshold["imag"]
    assert threshold["real"].pi == 1
    one = Scene(f"{text}[evaluation]\njnd = {{real = 0.2, imag = 0.3}}\n".encode(), None, ["evaluation", "jnd", "imag"])
    assert (one.threshold["real"].value, one.threshold["imag"].pi) == (Fraction(1, 5), 1)
    for path in (
        ["environment"], ["environment", "m"], ["environment", "model"], ["effects", "omega_c"], ["effects", 1, "omega_c"], ["effects", -1, "omega_c"],
        ["effects", False, "omega_c"], ["effects", "0", "omega_c"], ["environment", "k", 0], [], ["evaluation", "band", 0], [0], ["environment", 0.0],
    ):  # fmt: skip
        assert refused(f"{text}[evaluation]\nband = [1, 2]\n", free=path), path
    for other in (
        f"{text}[evaluation]\njnd = \"1 °\"\n", text.replace("omega_c = 7", 'omega_c = "7 Hz"'), text.replace("b = 5", 'b = "5 N s/m*rev"'),
        f'{text}[[effects]]\nmodel = "series"\nG = "2*pi"\n', f'{text}[[effects]]\nmodel = "coulomb-friction"\nforce = 1\namplitude = 1\n',
    ):  # fmt: skip
        assert refused(other, free=["environment", "k"]), other
        assert not refused(other)


@pytest.mark.parametrize("seed", range(4))
def test_chains_have_the_values_of_their_matrices(seed: int) -> None:
    """(A H + B)/(C H + D), one effect after the other, each formula written a second time."""
    draw = random.Random(seed)
    for _ in range(25):
        n = lambda: draw.randint(1, 9)  # noqa: E731
        x, t, re, im = draw.randint(1, 4), draw.randint(-5, 5), n(), n()
        s, u, z = 1j * x, (1 - 1j * t) / (1 + 1j * t), complex(re, im)  # s, exp(-s/4), s^(1/3)
        k, b, m, c = n(), n(), n(), n()
        Z = m * s**2 + b * s + k
        environments = [
            (environment("kelvin-voigt", f"k = {k}", f"b = {b}"), k + b * s),
            (environment("mass-spring-damper", f"m = {m}", f"k = {k}"), m * s**2 + k),
            (environment("maxwell", f"k = {k}", f"b = {b}"), k * b * s / (k + b * s)),
            (environment("zener", f"k0 = {k}", f"k1 = {c}", f"b1 = {b}"), k + c * b * s / (c + b * s)),
            (
                environment("prony", f"k0 = {k}", f"k = [{b}, {m}]", f"b = [{c}, {k}]"),
                k + b * c * s / (b + c * s) + m * k * s / (m + k * s),
            ),
            (environment("spring-pot", f"k_alpha = {c}", 'alpha = "1/3"', f"k = {k}"), k + c * z),
            (
                environment("expression", f'H = "a*s^(4/3) - {c}/s^2"', f"parameters = {{a = {k}}}"),
                k * s * z - c / s**2,
            ),
        ]
        text, H = draw.choice(environments)
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
        own = {"delays": (Fraction(1, 4),), "orders": (Fraction(1, 3),), "others": (t, (re, im))}
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
    t, x = 3, 5
    s, u, T = 1j * x, (1 - 1j * t) / (1 + 1j * t), 2
    turned = {
        "backward-difference": (1 - u) / T, "tustin": 2 * (1 - u) / (T * (1 + u)), "forward-difference": (1 - u) / (T * u),
    }  # fmt: skip
    for method, own in turned.items():
        for delay in (0, 1, 3):
            text = ENVIRONMENT + loop.format(method, delay)
            found = at(text, x, delays=(Fraction(2),), others=(t,))
            true = (3 + 5 * own) * u**delay * (1 - u) / (s * T)
            assert found == pytest.approx([3 + 5 * s, true])
            behind = at(f'{text}[[effects]]\nmodel = "shunt"\nk = 4\n', x, delays=(Fraction(2),), others=(t,))[1]
            assert behind == pytest.approx(true + 4)
    one = loop.format("tustin", 1)
    for text in (ENVIRONMENT + LAG + one, ENVIRONMENT + one + one, ENVIRONMENT + LAG + one + one):
        assert refused(text, delays=(Fraction(2),), others=(t,))
