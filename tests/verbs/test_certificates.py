"""A certificate is accepted by a program that shares nothing with haptisym, and whatever is wrong in one is refused."""

from __future__ import annotations

import copy
import json
import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from marks import often
from scenetexts import toml
from strategies import Seeded, case, coincident_case
from sympy import pi

import haptisym as hs
from haptisym import effects, environments
from haptisym.cli import main
from haptisym.judge.evaluation import Evaluation
from haptisym.model.expressions import evaluate
from haptisym.model.units import read_unit
from haptisym_check import RefusedError, check
from haptisym_check.scene import CATALOGUE, ONE, Number, Scene, Value, combined, quantity, unit, units
from haptisym_check.scene import evaluated as read_formula

SCENES = Path(hs.__file__).parent / "scenes"
RATIONAL = (
    "admittance-display", "control-stick-in-detail", "desktop-device-soft-tissue", "fu2019", "fu2019-tolerances",
    "helicopter-cyclic", "sidestick", "steering-wheel", "stick-with-friction", "two-mass-resonance", "undamped-resonance",
    "zener-tissue",
)  # fmt: skip
OWN = {
    "unstable": '[environment]\nmodel = "mass-spring-damper"\nm = 1\nb = 5\nk = 100\n[[effects]]\nmodel = "series"\n'
                'G = "100/(s^2 - 0.1*s + 100)"\n[evaluation]\nband = [0, 30]\n',
    "pole on the axis": '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 1\n[[effects]]\nmodel = "series"\nG = "w^2/(s^2 + w^2)"\n'
                        'parameters = { w = "2 Hz" }\n[evaluation]\nband = ["0 Hz", "1 Hz"]\n',
    "integrator": '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 1\n[[effects]]\nmodel = "series"\nG = "1 + 1/s"\n'
                  '[evaluation]\nband = [1, 30]\n',
    "touches": '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 0\n[[effects]]\nmodel = "series"\nG = "3*s/(s^2 + 3*s + 9)"\n'
               '[evaluation]\nband = [0, 9]\njnd = 1\n',
    "crossing at the end": '[environment]\nmodel = "mass-spring-damper"\nk = 100\n[[effects]]\nmodel = "shunt"\nm = "1 kg"\n'
                           '[evaluation]\nband = [0, 5]\njnd = "1/4"\n',
    "nothing between": '[environment]\nmodel = "prony"\nk0 = 100\nk = [50, 20]\nb = ["1 N*s/m", "2 N s/m"]\n',
}  # fmt: skip


def text_of(name: str) -> str:
    return OWN[name] if name in OWN else (SCENES / f"{name}.toml").read_text(encoding="utf-8")


@cache
def evaluated(name: str) -> Evaluation:
    return hs.evaluate(hs.parse_scene(text_of(name)))


@cache
def certificate(name: str) -> str:
    return evaluated(name).certificate()


def verdict(document: Any, scene: str) -> str:
    """What the checker says: the claim, or why not."""
    text = document if isinstance(document, str) else json.dumps(document)
    try:
        return check(text.encode(), scene.encode())
    except RefusedError as error:
        return f"refused: {error}"


# What is true is accepted.


@pytest.mark.parametrize("name", [*RATIONAL, *OWN])
def test_the_certificate_of_a_rational_scene_is_accepted(name: str) -> None:
    e, claim = evaluated(name), json.loads(certificate(name))["claim"]
    assert verdict(certificate(name), text_of(name)).startswith("Proven on the band")
    assert claim["stable"] == (None if name == "stick-with-friction" else e.stable)
    ends = [[Fraction(x) for x in claim["frequencies"][row["at"]]] for row in claim["crossings"]]
    document = e.to_dict()
    assert [(row["part"], row["kind"], row["sign"], row["multiplicity"]) for row in claim["crossings"]] == [
        (row["part"], row["kind"], row["sign"], row["multiplicity"]) for row in document["crossings"]
    ]
    for (low, high), row in zip(ends, document["crossings"], strict=True):
        assert Fraction(row["enclosure"][0]) <= high
        assert low <= Fraction(row["enclosure"][1])


def test_what_the_witnesses_of_stability_are() -> None:
    stable = {name: json.loads(certificate(name))["claim"]["stable"] for name in OWN}
    assert stable == {
        **dict.fromkeys(OWN, True),
        **dict.fromkeys(("unstable", "pole on the axis", "integrator"), False),
    }


def random_scene(seed: int) -> str:
    return toml((case if seed % 2 else coincident_case)(Seeded(seed)))


@pytest.mark.parametrize("first", often(range(0, 1000, 20), (0, 20).__contains__))
def test_certificates_of_random_scenes_are_accepted(first: int) -> None:
    for seed in range(first, first + 20):
        text = random_scene(seed)
        assert verdict(hs.evaluate(hs.parse_scene(text)).certificate(), text).startswith("Proven"), seed


def test_a_scene_of_several_environments_is_checked_by_name() -> None:
    text = (SCENES.parent / "families" / "palpation-device.toml").read_text(encoding="utf-8")
    proof = json.loads(hs.evaluate(hs.load_scene("palpation-device", "liver")).certificate())
    assert proof["environment"] == "liver"
    assert verdict(proof, text).startswith("Proven")
    for other in ("muscle", "none", None, 3):
        assert verdict({**proof, "environment": other}, text).startswith("refused")


def command(monkeypatch: pytest.MonkeyPatch, capsys: Any, *arguments: str) -> tuple[int, str]:
    """Exit status and standard error of haptisym."""
    monkeypatch.setattr("sys.argv", ["haptisym", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    return int(stop.value.code or 0), capsys.readouterr().err


def test_the_commands_write_and_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    target, scene = tmp_path / "proof.json", tmp_path / "scene.toml"
    scene.write_text(text_of("fu2019"), encoding="utf-8")
    written = command(monkeypatch, capsys, "evaluate", str(scene), "--certificate", str(target))
    assert written == (0, f"certificate written to {target}\n")
    checker = [sys.executable, "-m", "haptisym_check", str(target), str(scene)]
    checked = subprocess.run(checker, capture_output=True, text=True, check=False)
    assert checked.returncode == 0
    assert "2 crossings, none missed" in checked.stdout
    scene.write_text(text_of("fu2019") + "\n", encoding="utf-8")
    refused = subprocess.run(checker, capture_output=True, text=True, check=False)
    assert (refused.returncode, refused.stdout) == (1, "NOT proven: the certificate is that of another scene file\n")
    assert subprocess.run(checker[:-1], capture_output=True, check=False).returncode == 2


def test_what_the_format_has_no_room_for_is_a_sentence(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    lag = effects.first_order_lag(20)
    built = hs.Scene(environments.kelvin_voigt(290, 2), (lag,))
    fu2019 = hs.load_scene("fu2019")
    for question, words in {
        lambda: hs.evaluate("delayed-spring"): "needs a rational scene",
        lambda: hs.evaluate("organ-tissue"): "needs a rational scene",
        lambda: hs.evaluate(built): "write the scene to one",
        lambda: hs.evaluate(fu2019.with_values({"omega_n": 40})): "was changed since it was read",
        lambda: hs.evaluate("fu2019", tolerance="0.1"): "without a tolerance",
        lambda: hs.metrics("fu2019"): "has no certificate",
    }.items():
        with pytest.raises(hs.SceneError, match=words):
            question().certificate()  # type: ignore[attr-defined]
    status, said = command(monkeypatch, capsys, "evaluate", "palpation-device", "--certificate", "x.json")
    assert (status, "--environment NAME" in said) == (2, True)


# What is false is refused.


def mutants(proof: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Changes each of which makes the claim false, or the proof incomplete."""

    def changed(name: str, change: Callable[[dict[str, Any]], object]) -> tuple[str, dict[str, Any]]:
        other = copy.deepcopy(proof)
        change(other)
        return name, other

    factors, functions = proof["proof"]["factors"], proof["proof"]["functions"]
    inner = len(proof["proof"]["breakpoints"]) - 1
    for i in range(1, inner) if inner < 12 else ():
        yield changed(f"breakpoint {i} left out", lambda x, i=i: x["proof"]["breakpoints"].pop(i))
    yield changed("the last cell left out", lambda x: x["proof"]["breakpoints"].pop())
    yield changed("the first cell left out", lambda x: x["proof"]["breakpoints"].pop(0))
    for i, factor in enumerate(factors):
        for k, row in enumerate(factor["polynomial"]):
            last = str(int(row[0]) + 1)
            yield changed(
                f"coefficient {k} of factor {i}",
                lambda x, i=i, k=k, last=last: x["proof"]["factors"][i]["polynomial"][k].__setitem__(0, last),
            )
        yield changed(f"factor {i} of lower degree", lambda x, i=i: x["proof"]["factors"][i]["polynomial"].pop())
        if len(factor["polynomial"]) > 1:
            other = 3 - factor["step"]
            yield changed(f"step of factor {i}", lambda x, i=i, n=other: x["proof"]["factors"][i].update(step=n))
    for name, told in functions.items():
        own = lambda x, name=name: x["proof"]["functions"][name]  # noqa: E731
        if told["number"] != "0":
            yield changed(
                f"{name} with another sign",
                lambda x, own=own, n=told["number"]: own(x).update(number=str(-Fraction(n))),
            )
            yield changed(
                f"{name} with another number",
                lambda x, own=own, n=told["number"]: own(x).update(number=str(Fraction(n) * 2)),
            )
            yield changed(f"{name} zero", lambda x, own=own: own(x).update(number="0"))
        yield changed(
            f"{name} times omega^2",
            lambda x, own=own, n=told["omega"] + 2 if told["number"] != "0" else 501: own(x).update(omega=n),
        )
        for i in range(len(told["powers"])):
            yield changed(f"{name} without a factor", lambda x, own=own, i=i: own(x)["powers"].pop(i))
            yield changed(
                f"{name} with a square",
                lambda x, own=own, i=i: own(x)["powers"][i].__setitem__(1, own(x)["powers"][i][1] + 2),
            )
    for key, value in proof["claim"].items():
        yield changed(f"{key} not claimed", lambda x, key=key: x["claim"].pop(key))
        if isinstance(value, list):
            for i in range(len(value)):
                yield changed(f"{key} without {i}", lambda x, key=key, i=i: x["claim"][key].pop(i))
                yield changed(
                    f"{key} with {i} twice", lambda x, key=key, i=i: x["claim"][key].insert(i, x["claim"][key][i])
                )
    for i, row in enumerate(proof["claim"]["crossings"]):
        wrong = {"at": row["at"] + 1, "part": {"real": "imag", "imag": "real"}[row["part"]], "kind": "touches" if row["kind"] != "touches" else "exceeds",
                 "sign": -row["sign"] or 1, "multiplicity": row["multiplicity"] + 1}  # fmt: skip
        for key, other in wrong.items():
            yield changed(
                f"{key} of crossing {i}",
                lambda x, i=i, key=key, other=other: x["claim"]["crossings"][i].update({key: other}),
            )
        yield changed("true for 1", lambda x, i=i: x["claim"]["crossings"][i].update(multiplicity=True))
    for i, (low, high) in enumerate(proof["claim"]["frequencies"]):
        beyond = str(Fraction(high) + (Fraction(high) - Fraction(low) or Fraction(1, 1000)))
        yield changed(
            f"enclosure {i} beside it", lambda x, i=i, a=beyond: x["claim"]["frequencies"].__setitem__(i, [a, a])
        )
        yield changed(
            f"enclosure {i} reversed",
            lambda x, i=i, a=high, b=str(Fraction(low) - 1): x["claim"]["frequencies"].__setitem__(i, [a, b]),
        )
    yield changed("stable otherwise", lambda x: x["claim"].update(stable=not x["claim"]["stable"]))
    yield changed(
        "no poles", lambda x: x["proof"].update(poles=None) if x["claim"]["stable"] is not None else x.pop("proof")
    )
    poles = proof["proof"]["poles"] or {"turns": None, "factors": []}
    for i, turns in enumerate(poles["turns"] or []):
        for k in range(len(turns)):
            yield changed(
                f"turn {k} of factor {i} left out", lambda x, i=i, k=k: x["proof"]["poles"]["turns"][i].pop(k)
            )
            yield changed(
                f"turn {k} of factor {i} at 0", lambda x, i=i, k=k: x["proof"]["poles"]["turns"][i].__setitem__(k, "0")
            )
    for i in range(len(poles["factors"])):
        yield changed(f"pole {i} left out", lambda x, i=i: x["proof"]["poles"]["factors"].pop(i))
    for key in ("format", "scene_sha256", "environment", "claim", "proof"):
        yield changed(f"{key} left out", lambda x, key=key: x.pop(key))
        yield changed(f"{key} of another kind", lambda x, key=key: x.update({key: 7}))
    yield changed("another scene's hash", lambda x: x.update(scene_sha256="0" * 64))
    yield changed("a further key", lambda x: x.update(note=""))


@pytest.mark.parametrize(
    "name", often([*OWN, *RATIONAL], {"fu2019", "touches", "integrator", "crossing at the end"}.__contains__)
)
def test_every_mutant_is_refused(name: str) -> None:
    passed = [
        what
        for what, x in mutants(json.loads(certificate(name)))
        if not verdict(x, text_of(name)).startswith("refused")
    ]
    assert passed == []


@pytest.mark.parametrize("seed", often(range(40), (0, 1).__contains__))
def test_a_changed_character_is_refused_or_leaves_a_claim_that_is_true(seed: int) -> None:
    """A wider enclosure, or a breakpoint that is moved a little, proves what is true all the same."""
    source, e = random.Random(seed), evaluated("fu2019")
    text, own = certificate("fu2019"), json.loads(certificate("fu2019"))["claim"]
    for _ in range(40):
        at = source.randrange(len(text))
        other = text[:at] + source.choice('0123456789-/.E[]{}",: ant') + text[at + 1 :]
        if not verdict(other, text_of("fu2019")).startswith("refused"):
            claim = json.loads(other)["claim"]
            assert {**claim, "frequencies": None} == {**own, "frequencies": None}
            for (low, high), point in zip(claim["frequencies"], e.chart.points, strict=True):
                a, b = point.omega.bounds(200)
                assert Fraction(low) <= a <= b <= Fraction(high), other


HOSTILE = {
    "nothing": "",
    "no object": "[]",
    "not a number": '{"format": NaN}',
    "infinite": '{"format": Infinity}',
    "deep": "[" * 1_000_000,
    "deep objects": '{"a":' * 200_000,
    "twice": '{"format": "haptisym.certificate/1", "format": "haptisym.certificate/1"}',
    "large": " " * 5_000_000,
    "a huge whole number": '{"format": 1' + "0" * 1_000_000 + "}",
    "a float": '{"format": 1.5}',
    "half a surrogate": '{"format": "\\ud800"}',
}


def hostile() -> Iterator[tuple[str, str]]:
    """Documents that ask for more time or memory than there is, or for what is not there."""
    yield from HOSTILE.items()
    good = json.loads(certificate("fu2019"))

    def with_proof(**other: Any) -> str:
        return json.dumps({**good, "proof": {**good["proof"], **other}})

    first = good["proof"]["factors"][0]
    yield "a million leaves", with_proof(breakpoints=[str(n) for n in range(400_000)])
    yield "breakpoints as high as one likes", with_proof(breakpoints=["0", "1E999", "15"])
    yield "breakpoints as long as one likes", with_proof(breakpoints=["0", "1/" + "9" * 1_000_000, "15"])
    yield "fine breakpoints", with_proof(breakpoints=["0", *(f"{n}/1{'0' * 1500}" for n in range(1, 1000)), "15"])
    yield "a long coefficient", with_proof(factors=[{"step": 2, "polynomial": [["9" * 3_000_000]]}])
    yield "a high degree", with_proof(factors=[{"step": 2, "polynomial": [["1"]] * 300}] * 400)
    yield "high powers of pi", with_proof(factors=[{"step": 2, "polynomial": [["1"] * 100] * 100}] * 20)
    powers = {
        name: {**x, "powers": [[i, 100] for i in range(len(good["proof"]["factors"]))]}
        for name, x in good["proof"]["functions"].items()
    }
    yield "high exponents", with_proof(functions=powers)
    yield "a factor that is not there", with_proof(factors=[first])
    yield "lists for numbers", with_proof(breakpoints=[[], {}])
    yield "null", with_proof(functions=None)
    yield "other digits", with_proof(breakpoints=["٣", "15"])


def limited(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run with at most 20 seconds and 600 MB."""
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_AS, (600_000_000, 600_000_000))\n"
    command = [sys.executable, "-c", limit + code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=20)


@pytest.mark.parametrize("name", [name for name, _ in hostile()])
def test_hostile_documents_are_refused_in_bounded_time_and_memory(name: str, tmp_path: Path) -> None:
    file = tmp_path / "proof.json"
    file.write_text(dict(hostile())[name], encoding="utf-8", errors="surrogatepass")
    code = "import sys\nfrom haptisym_check.__main__ import main\nsys.exit(main(sys.argv[1:]))"
    done = limited(code, str(file), str(SCENES / "fu2019.toml"))
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("NOT proven: ")


@pytest.mark.parametrize(
    ("field", "wrong"),
    [("crossings", lambda x: x[:1]), ("crossings", lambda x: (replace(x[0], sign=-x[0].sign), *x[1:])), ("transparent", lambda _: ()),
     ("percepts", lambda x: x[1:]), ("changeovers_perceived", lambda _: ()), ("outside_model", lambda _: None)],
)  # fmt: skip
def test_a_wrong_answer_gets_no_certificate_that_passes(field: str, wrong: Callable[[Any], Any]) -> None:
    e = hs.evaluate("fu2019")
    value = wrong(getattr(e, field))
    e.__dict__[field] = e.transparent if value is None else value
    assert verdict(e.certificate(), text_of("fu2019")).startswith("refused")


def test_a_wrong_stability_gets_no_certificate_that_passes() -> None:
    for name, stable in (("fu2019", False), ("unstable", True)):
        claim = json.loads(replace(evaluated(name), stable=stable).certificate())
        said = verdict(claim, text_of(name))
        assert said.startswith("refused") or claim["claim"]["stable"] is None


# What the checker reads.


def test_units_mean_what_haptisym_takes_them_for() -> None:
    known = [name for name in CATALOGUE["units"] if name != "1"]
    prefixed = [f"{x}{name}" for x in CATALOGUE["prefixes"] for name in known if CATALOGUE["units"][name][3]]
    for name in [*known, *prefixed, "N*s/m", "kg*m^2", "1/s"]:
        text = "1" if name == "1/s" else name
        factor, exponents = read_unit(name, name, "")
        mine = quantity(f"1 {name}") if name != "1/s" else units("/", unit("1"), unit("s"))
        assert [exponents.get(x, 0) for x in ("mass", "length", "time")] == mine.dimension, text
        assert factor == mine.value.numerator * pi**mine.pi / mine.value.denominator, text


@pytest.mark.parametrize(
    "change",
    [('model = "second-order-lowpass"', 'model = "third-order-lowpass"'), ('"80 rad/s"', '"80 rad"'), ('"80 rad/s"', '"80 furlong/s"'),
     ('"80 rad/s"', '"8O rad/s"'), ("zeta = 0.5", "zeta = 0.5\neta = 1"), ("zeta = 0.5", ""), ("[evaluation]", "[evaluation]\nx = 1"),
     ("jnd = 0.10", 'jnd = { shape = "diamond", real = 0.1, imag = 0.1 }'), ("jnd = 0.10", 'jnd = "0.08 + 0.004*omega"'),
     ("[evaluation]", "[x]\n[evaluation]"), ("zeta = 0.5", "zeta = nan"), ("zeta = 0.5", "zeta = 1e999999999"),
     ("[evaluation]", '[[effects]]\nmodel = "delay"\ntau = "1 ms"\n[evaluation]'),
     ("[evaluation]", '[[effects]]\nmodel = "series"\nG = "s(s)"\n[evaluation]'),
     ("[evaluation]", '[[effects]]\nmodel = "series"\nG = "__import__"\n[evaluation]'),
     ("[evaluation]", '[[effects]]\nmodel = "series"\nG = "((s^99)^99)^99"\n[evaluation]'),
     ("[evaluation]", f'[[effects]]\nmodel = "series"\nG = "{"(" * 900}s{")" * 900}"\n[evaluation]')],
)  # fmt: skip
def test_a_scene_that_is_not_understood_is_refused(change: tuple[str, str]) -> None:
    text = text_of("fu2019")
    assert change[0] in text
    with pytest.raises(RefusedError):
        Scene(text.replace(*change).encode(), None).at(Value(0, 1, s=1), 1)


def test_formulas_are_read_as_haptisym_reads_them() -> None:
    for text in ("2*x^2 - (x + 1)/4", "-x^2", "2*-x", "x^-2 + x**(+3)", "1e-1*x/.5/x", "((x))", "- -x", "x^0"):
        top, bottom = read_formula(
            text, lambda word: (Value(3), ONE) if word == "x" else Number(Fraction(word)).at(1), combined
        )
        assert Fraction(top.re, bottom.re) == evaluate(text, number=Fraction, name={"x": Fraction(3)}.__getitem__), text
