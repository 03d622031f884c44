"""Both checkers accept and refuse the same certificates, however these are changed or written, and what they accept is true."""

from __future__ import annotations

import json
import os
import random
import resource
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from time import process_time
from typing import Any

import pytest
from certificates import (
    CANCELLING,
    HELD,
    OWN,
    certificate,
    fractional_scene,
    late_scene,
    of_requirement,
    of_stability,
    text_of,
)
from forgeries import evaluated, gain, of_scene
from marks import often
from mutated import mutated
from secondchecker import cells, verdicts

from haptisym import SceneError, parse_scene, stability
from haptisym_check import RefusedError, check, waves


def said(proof: str, scene: str) -> str:
    """The claim, or nothing where it is refused."""
    try:
        return check(proof.encode("utf-8", "surrogatepass"), scene.encode())
    except RefusedError:
        return ""


def accepted(asked: list[tuple[str, str]]) -> list[bool]:
    """Whether each certificate is accepted for its scene, by both checkers."""
    found = [said(*pair) != "" for pair in asked]
    assert found == [claim is not None for claim, _ in verdicts(asked)]
    return found


SMALL = ("fu2019", "sidestick", *OWN)
VALUED = ("up to a value", "a threshold", "two intervals", "a threshold above a delay", "a device on a power")


def truths() -> list[tuple[str, str]]:
    """Certificates and their scenes, of each question."""
    asked = [(certificate(name), text_of(name)) for name in SMALL] + [of_stability(name) for name in HELD]
    return asked + [of_requirement(name) for name in VALUED]


@pytest.mark.slow
def test_delays_and_orders_of_a_proof_are_positive_and_no_larger_than_they_may_be() -> None:
    """Beside a scene that has none they change nothing, and so both checkers take those that the format allows, and no others."""
    proof, scene = certificate("fu2019"), text_of("fu2019")
    small, huge = f"1/{2**100 - 1}", str(2**100 - 1)
    for key, allowed, others in (
        ("delays", ["1/3", "5", small, huge], ["0", "-1/3", str(2**100), f"1/{2**100}", f"3/{2**100 + 1}"]),
        ("orders", ["1/3", small, f"{2**100 - 2}/{huge}"], ["0", "-1/3", "1", "4/3", f"1/{2**100}", f"3/{2**100 + 1}"]),
    ):
        own = json.loads(proof)["proof"][key]
        asked = [(proof.replace(f'"{key}": []', f'"{key}": ["{x}"]', 1), scene) for x in (*allowed, *others)]
        assert own == []
        assert all(x != proof for x, _ in asked)
        assert accepted(asked) == [True] * len(allowed) + [False] * len(others)


@pytest.mark.slow
@pytest.mark.parametrize(
    "seeds", often([range(20), *(range(n, n + 200) for n in range(20, 2020, 200))], range(20).__eq__, 2)
)
def test_random_mutants_are_refused_by_both_or_true(seeds: range) -> None:
    asked = truths()
    proofs = [json.loads(proof) for proof, _ in asked]
    listed = [mutated(seed, proofs) for seed in seeds]
    second = verdicts([(text, asked[i][1]) for i, text in listed])
    for seed, (i, text), (claim, why) in zip(seeds, listed, second, strict=True):
        passes = said(text, asked[i][1]) != ""
        assert passes == (claim is not None), (seed, why)
        assert not passes or means_the_same(json.loads(text)["claim"], proofs[i]["claim"]), seed


def means_the_same(claim: dict[str, Any], own: dict[str, Any]) -> bool:
    """Whether only numbers are written otherwise, or enclosures hold the same."""
    told, true = (x.pop("frequencies", []) for x in ({**claim}, {**own}))
    if len(told) != len(true) or _plain({**claim, "frequencies": 0}) != _plain({**own, "frequencies": 0}):
        return False
    ends = [[Fraction(x) for x in (*a, *b)] for a, b in zip(told, true, strict=True)]
    return all(a <= d and c <= b for a, b, c, d in ends)


def _plain(x: Any) -> Any:
    """With one way to write each number."""
    if isinstance(x, dict):
        return {key: _plain(y) for key, y in x.items()}
    if isinstance(x, list):
        return [_plain(y) for y in x]
    try:
        return Fraction(x) if isinstance(x, str) else x
    except ValueError:
        return x


def test_files_that_are_too_large_are_not_looked_into() -> None:
    most, most_of_scene = 4_000_000, 1_000_000
    for size, size_of_scene, is_refused in (
        (most, most_of_scene, False), (most + 1, 0, True), (0, most_of_scene + 1, True), (most + 1, most_of_scene + 1, True), (most + 1, most_of_scene, True),
        (most, most_of_scene + 1, True),
    ):  # fmt: skip
        with pytest.raises(RefusedError) as error:
            check(b"x" * size, b"x" * size_of_scene)
        assert ("too large" in str(error.value)) == is_refused
    nested = lambda n: b"[" * n + b"]" * n  # noqa: E731
    for n, words in ((18, "expected an object"), (19, "expected an object"), (20, "too deeply"), (90, "too deeply")):
        with pytest.raises(RefusedError, match=words):
            check(nested(n), b"")


def test_json_may_be_written_in_every_way() -> None:
    proof, scene = certificate("fu2019"), text_of("fu2019")
    true = [
        proof.replace('"real"', '"re\\u0061l"'),
        proof.replace("[[0, ", "[[-0, "),
        json.dumps(json.loads(proof), indent="\t").replace("\n", "\r\n"),
    ]
    wrong = [
        proof.replace('"real"', '"re\\u0061l'),
        proof.replace('"at": ', '"\\u0061t": 1, "at": '),
        proof.replace("[[0, ", "[[-0.0, "),
        proof.replace("[[0, ", "[[0e0, "),
        proof.replace(" ", "\u00a0"),
    ]
    assert proof not in (*true, *wrong)
    assert accepted([(x, scene) for x in (*true, *wrong)]) == [True] * len(true) + [False] * len(wrong)


@pytest.mark.slow
def test_files_are_measured_in_bytes() -> None:
    proof, scene = certificate("fu2019"), text_of("fu2019")
    large = [proof + " " * (size - len(proof.encode())) for size in (4_000_000, 4_000_001)]
    scenes = [f"{scene}\n# {'é' * ((size - len(scene.encode()) - 3) // 2)}" for size in (999_900, 1_000_002)]
    asked = [(x, scene) for x in large] + [(of_scene(json.loads(proof), x), x) for x in scenes]
    assert accepted(asked) == [True, False, True, False]


AT_A_POLE = """[environment]
model = "expression"
H = "1/(s^2 + 100)"
[[effects]]
model = "series"
G = "1 - s^2/1000"
[evaluation]
band = [0, 10]
jnd = 0.1
"""


def test_a_crossing_at_a_pole_at_the_end_of_the_band_is_accepted() -> None:
    proof = evaluated(AT_A_POLE)
    [row] = proof["claim"]["crossings"]
    assert (row["at"], row["kind"], row["sign"]) == (1, "exceeds", -1)
    true = of_scene(proof, AT_A_POLE)
    row["sign"] = 1
    assert accepted([(true, AT_A_POLE), (of_scene(proof, AT_A_POLE), AT_A_POLE)]) == [True, False]


def test_a_claim_about_no_part_is_refused() -> None:
    proof, scene = of_requirement("up to a value")
    told = json.loads(proof)
    told["claim"]["parts"], told["proof"]["functions"] = ["number"], {}
    assert accepted([(json.dumps(told), scene)]) == [False]


def test_words_say_of_a_frequency_between_which_numbers_it_lies() -> None:
    told = json.loads(certificate("fu2019"))
    ends = told["claim"]["frequencies"]
    ends[0], ends[-1], at = ["-1000", "1000"], ["-5", "1E9"], told["claim"]["crossings"][0]["at"]
    ends[at] = ["7.97", "7.99"]
    lines = said(json.dumps(told), text_of("fu2019")).splitlines()
    assert lines[0] == "Proven on the band from [-1000, 1000] to [-5, 1E9] rad/s: 2 crossings, none missed."
    assert "  real part exceeds its threshold at [7.97, 7.99] rad/s" in lines
    assert "  transparent from [-1000, 1000] to [7.97, 7.99] rad/s" in lines


def test_what_is_not_understood_is_one_line_on_any_terminal(tmp_path: Path) -> None:
    scene = f'"é\\nProven on the band" = 1\n{text_of("fu2019")}'
    (tmp_path / "proof.json").write_text(of_scene(json.loads(certificate("fu2019")), scene), encoding="utf-8")
    (tmp_path / "scene.toml").write_text(scene, encoding="utf-8", newline="")
    command = [sys.executable, "-m", "haptisym_check", "proof.json", "scene.toml"]
    own = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, env=own)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout == "NOT proven: keys of the scene are not understood: ['\\xe9\\nProven on the band']\n"


@pytest.mark.slow
def test_numbers_of_a_scene_may_be_written_in_every_way_of_toml() -> None:
    own, ways = text_of("fu2019"), ("0.5_0", "5e-1", "0.0_5e+1", "5_0E-02", "1", "+1", "0x0_1", "0o1", "0b1")
    scenes = [own.replace("zeta = 0.5", f"zeta = {x}") for x in ways]
    assert own not in scenes
    halves, ones = (evaluated(own.replace("zeta = 0.5", f"zeta = {x}")) for x in ("0.5", "1"))
    asked = [(of_scene(proof, scene), scene) for proof in (halves, ones) for scene in scenes]
    assert accepted(asked) == [True] * 4 + [False] * 5 + [False] * 4 + [True] * 5


def test_what_is_felt_as_nothing_has_a_certificate() -> None:
    """1/H_perc is none: nothing is said of its zeros."""
    text = gain("s - s", "1/10", "[1, 15]")
    proof = evaluated(text)
    assert proof["claim"]["stable"] is None
    assert accepted([(of_scene(proof, text), text)]) == [True]
    with pytest.raises(SceneError, match="its force is zero everywhere"):
        stability(parse_scene(text)).certificate()


def test_a_power_behind_a_sign_and_a_power_is_not_understood() -> None:
    """It needs parentheses: -s^2^3 is not (-s^2)^3, as a checker might read it."""
    text = '[environment]\nmodel = "expression"\nH = "{}"\n[evaluation]\nband = [1, 5]\n'
    odd, plain = text.format("-s^2^3"), text.format("-s^6")
    proof = evaluated(plain)
    assert accepted([(of_scene(proof, odd), odd), (of_scene(proof, plain), plain)]) == [False, True]


@pytest.mark.slow
def test_a_factor_that_is_zero_where_two_tangents_are_equal_is_one_like_any_other() -> None:
    """sin (omega (tau - tau')/2), whose square cancels."""
    told = json.loads(certificate("two delays"))
    own = told["proof"]
    count = len(own["factors"])
    own["factors"] += [{"waves": [1, 1], "terms": [[[1, 0], [["1"]]], [[0, 1], [["-1"]]]]}] * 2
    own["functions"]["sum.real"]["powers"] += [[count, 2], [count + 1, -2]]
    assert accepted([(json.dumps(told), text_of("two delays"))]) == [True]


def in_a_row(count: int) -> str:
    """A scene of so many lags in Hz."""
    lag = '[[effects]]\nmodel = "second-order-lowpass"\nomega_n = "{} Hz"\nzeta = 0.5\n'
    effects = "".join(lag.format(12 + n) for n in range(count))
    return f'[environment]\nmodel = "kelvin-voigt"\nk = 290\nb = 2\n{effects}[evaluation]\nband = [0, 15]\n'


def test_a_scene_for_which_no_checker_works_long_enough_gets_a_sentence() -> None:
    with pytest.raises(SceneError, match="no checker accepts a certificate of this scene: the degrees are too high"):
        evaluated(in_a_row(9))


@pytest.mark.slow
def test_a_scene_for_which_a_checker_works_for_seconds_has_a_certificate() -> None:
    text = in_a_row(5)
    assert accepted([(of_scene(evaluated(text), text), text)]) == [True]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 19, 33, 37])
def test_a_delay_that_turns_often_has_a_certificate_that_is_checked_in_ten_seconds(seed: int) -> None:
    """Some hundred crossings, each with a cell and two long enclosures; of the processor's time, in either checker."""
    text = late_scene(seed)
    proof = of_scene(evaluated(text), text)
    start = process_time()
    assert said(proof, text).startswith("Proven on the band")
    assert process_time() - start < 10
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    assert verdicts([(proof, text)])[0][0] is not None
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before < 10


@pytest.mark.slow
@pytest.mark.parametrize(("make", "seeds"), [(late_scene, (1, 5, 14)), (fractional_scene, (4, 5, 10))])
def test_both_say_the_same_of_cells_that_are_wider_than_they_were_written(make: Any, seeds: Any) -> None:
    asked = list[tuple[str, str]]()
    for seed in seeds:
        text = make(seed)
        proof = json.loads(of_scene(evaluated(text), text))
        points = proof["proof"]["breakpoints"]
        for i in range(1, min(len(points) - 1, 5)):
            own = proof["proof"] | {"breakpoints": points[:i] + points[i + 1 :]}
            asked.append((json.dumps(proof | {"proof": own}), text))
    assert {*accepted(asked)} == {True, False}


def with_powers(formula: str) -> str:
    """A scene of this environment, behind a lag."""
    lag = '[[effects]]\nmodel = "first-order-lag"\nomega_c = 20\n'
    return f'[environment]\nmodel = "expression"\nH = "{formula}"\n{lag}[evaluation]\nband = [1, 15]\n'


@pytest.mark.slow
@pytest.mark.parametrize(("formula", "same"), CANCELLING)
def test_powers_of_s_that_cancel_have_a_certificate_that_says_what_it_says_without_them(
    formula: str, same: str
) -> None:
    long, short = (evaluated(with_powers(x)) for x in (formula, same))
    assert long["claim"]["crossings"] == short["claim"]["crossings"] != []
    assert long["claim"]["frequencies"] == short["claim"]["frequencies"]
    asked = [(long, with_powers(formula)), (long, with_powers(same.replace("30", "31")))]
    assert accepted([(of_scene(x, text), text) for x, text in asked]) == [True, False]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("formula", "why"),
    [("300 + s^0.5 - s^0.5", "the proof has no such order"), ("300 + (s^0.5)^0.5", r"the name '\(\^1/2' is not known")],
)
def test_powers_that_a_checker_does_not_see_through_get_a_sentence(formula: str, why: str) -> None:
    with pytest.raises(SceneError, match=f"no checker accepts a certificate of this scene: .*{why}"):
        evaluated(with_powers(formula))


@pytest.mark.slow
@pytest.mark.parametrize("written", ['"H" = "{}"', "H = '''\n{}'''", 'H = """{}\n"""', "H = '{}'"])
def test_powers_are_asked_about_however_a_formula_is_written(written: str) -> None:
    formula = "300 + s^0.5 - s^0.5"
    with pytest.raises(SceneError, match="no checker accepts a certificate of this scene"):
        evaluated(with_powers(formula).replace(f'H = "{formula}"', written.format(formula)))


@pytest.mark.slow
def test_a_function_that_is_zero_because_of_an_order_gets_a_sentence() -> None:
    text = with_powers("s^0.5").replace('"first-order-lag"\nomega_c = 20', '"series"\nG = "s^0.5"')
    with pytest.raises(SceneError, match=r"as Re s\^0\.5 s\^0\.5"):
        evaluated(text)


def drawn_cell(draw: random.Random) -> tuple[Any, ...]:
    """A factor with waves, delays, orders and a cell, from 0 on or beyond, in which it often has a zero."""

    def positive(low: int, high: int) -> Fraction:
        return Fraction(draw.randint(1, 99), draw.randint(1, 99)) * Fraction(10) ** draw.randint(low, high)

    delays = [positive(-3, 1) for _ in range(draw.randint(0, 2))]
    orders = [Fraction(draw.randint(1, 15), 16) for _ in range(draw.randint(not delays, 2))]
    scale = 1 / max([*delays, Fraction(1)])
    a = Fraction(0) if draw.random() < 0.3 else scale * positive(-1, 1)
    b = a + scale * positive(*draw.choice([(-4, -1), (-1, 0), (0, 0)]))
    waved = [draw.randint(0, 3) for _ in delays]
    rows = {}
    for _ in range(draw.randint(1, 3)):
        turns = (*(draw.randint(0, n) for n in waved), *(draw.choice([0, 0, 1, 2]) for _ in range(2 * len(orders))))
        root = a + (b - a) * Fraction(draw.randint(-500, 1500), 1000)
        p = [[-root.numerator], [root.denominator]]
        if draw.random() < 0.4:
            p = [[draw.randint(-9, 9)] for _ in range(draw.randint(0, 3))] + [[draw.randint(1, 9), draw.randint(1, 9)]]
        rows[turns] = p
    terms = [[list(turns), [[str(c) for c in row] for row in p]] for turns, p in rows.items()]
    return {"waves": waved, "terms": terms}, delays, orders, a, b


def judged(told: Any, delays: list[Fraction], orders: list[Fraction], a: Fraction, b: Fraction) -> list[Any]:
    f, found = waves.WaveFactor(told, tuple(delays), tuple(orders)), list[Any]()
    for work in (lambda: f.model(f.all, a, b) if a else None, lambda: f.signs(a, b)):
        try:
            found.append(work())
        except RefusedError:
            found.append(None)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_both_bound_and_judge_cells_of_factors_with_waves_alike(seed: int) -> None:
    draw = random.Random(seed)
    asked = [drawn_cell(draw) for _ in range(800)]
    written = [(x[0], *([str(y) for y in z] for z in x[1:3]), str(x[3]), str(x[4])) for x in asked]
    told = 0
    for x, (model, signs) in zip(asked, cells(written), strict=True):
        own_model, own_signs = judged(*x)
        assert (own_model is None, own_signs is None) == (model is None, signs is None), x
        if own_model is not None:
            (row, lost), (other, off) = own_model, model
            assert sum(abs(c - int(d)) for c, d in zip(row, other, strict=True)) <= lost
            assert abs(lost - int(off)) * 1000 <= lost
        if own_signs is not None:
            assert (Fraction(own_signs[0]), own_signs[1]) == (Fraction(signs[0]), signs[1])
            told += 1
    assert 200 < told < 700
