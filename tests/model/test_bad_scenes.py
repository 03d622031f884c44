"""A wrong scene ends with exit status 2 and one message that names file, key, value and rule; nothing is executed."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path

import pytest
from sympy import Rational

from haptisym import SceneError, load_scene, parse_scene
from haptisym.cli import main

ENVIRONMENT = '[environment]\nmodel = "mass-spring-damper"\nm = "1.8 kg"\nb = "15 N*s/m"\nk = "100 N/m"\n'
FILTER = '[[effects]]\nmodel = "first-order-lag"\nomega_c = "80 rad/s"\n'


def env(text: str) -> str:
    return f"[environment]\n{text}\n"


def expression(formula: str) -> str:
    return env(f"model = 'expression'\nH = {formula!r}\nparameters = {{ m = '2 kg' }}")


def evaluation(text: str) -> str:
    return f"{ENVIRONMENT}{FILTER}[evaluation]\n{text}\n"


BAD = {
    # syntax
    "not toml": ("this is not TOML", ["TOML"]),
    "unclosed string": ('title = "x', ["TOML"]),
    "a key twice": ("[environment]\nmodel='maxwell'\nmodel='maxwell'", ["TOML"]),
    "empty": ("", ["environment", "missing"]),
    "environment not a table": ("environment = 3", ["environment", "3", "table"]),
    "effects not a list": (f"{ENVIRONMENT}[effects]\nmodel='delay'", ["effects", "[[effects]]"]),
    "deep nesting": ("a = " + "[" * 20_000, ["TOML", "nested"]),
    "a number of ten thousand digits": (env(f"model='mass-spring-damper'\nk = {'9' * 10_000}"), ["TOML"]),
    "several environments without an s": (
        "[[environment]]\nmodel='maxwell'\nk=1\nb=2",
        ["[environment]", "[[environments]]"],
    ),
    # formulas: what is really wrong
    "an exponent that is a formula": (expression("s^(10^9)"), ["an exponent must be one number", "s^(-1/2)"]),
    "an exponent that is a quotient of decimals": (
        expression("m*s^(0.5/2)"),
        ["a quotient as an exponent is one of whole numbers"],
    ),
    "a root of a sum": (expression("m*(s + 1)^0.5"), ["environment", "(s + 1)^(1/2) is no power of s", "0.17*s^0.5"]),
    "a root of a number": (expression("m*(s/33)^0.5"), ["environment", "(33)^(1/2) is no power of s", "of s alone"]),
    "a root of a square": (expression("m*(s^2)^0.5"), ["environment", "(s^2)^(1/2) is no power of s"]),
    "an exponent in powers of ten": (expression("m*s^1e1"), ["an exponent must be a short plain number"]),
    "a broken exponent below zero that is too high": (expression("m*s^(-60.5)"), ["the degree, 61, is higher than 60"]),
    "a long sum": (expression("+".join([f"{i}{'7' * 180}*s^{i}" for i in range(12)])), ["more than 2000 digits"]),
    "a quantity that is too small": (env("model='mass-spring-damper'\nk = '1e-301 N/m'"), ["exponents of ten", "-300"]),
    "a quantity that is too large in SI": (
        env("model='mass-spring-damper'\nk = '1e300 kN/m'"),
        ["between 1e-300 and 1e300"],
    ),
    "a band in kilograms": (
        f"{ENVIRONMENT}[evaluation]\nband = ['0 kg', '1 Hz']",
        ["evaluation: band", '"0 kg" is not a frequency'],
    ),
    "an exponent that divides": (
        expression("m*s^(1/0)"),
        ["a quotient as an exponent is one of whole numbers up to 99", "m*s^(1/0)"],
    ),
    "an exponent without its parenthesis": (expression("m*s^(2"), ['expected ")"']),
    "a division by zero": (expression("1/0"), ["division by zero"]),
    "a delay as exp": (expression("m*exp(-s*m)"), ["[[effects]]", 'model = "delay"', "tau"]),
    "a delay as a power of e": (expression("m*e^(-s*m)"), ["[[effects]]", 'model = "delay"', "tau"]),
    "a root": (expression("m*sqrt(s)"), ["functions", "s^0.5"]),
    "a hyperbolic function": (expression("m*cosh(s)"), ["functions", "wave-variables"]),
    "a sine": (expression("m*sin(s)"), ["functions", "+ - * / and ^ alone"]),
    "a product without its sign": (expression("m(s + 1)"), ['"m*("']),
    "a product without its sign after a number": (expression("2 m"), ["an operator such as *"]),
    # names
    "unknown top-level key": (f"{ENVIRONMENT}[evalution]\nband=[0,1]", ["evalution", "evaluation"]),
    "unknown environment": (env("model='mass-spring-dampr'"), ["mass-spring-dampr", "mass-spring-damper"]),
    "unknown effect": (f"{ENVIRONMENT}[[effects]]\nmodel='lowpass'", ["effects[1]", "lowpass", "second-order-lowpass"]),
    "model missing": (env("m = 3"), ["environment", "model", "missing"]),
    "model not a string": (env("model = 3"), ["environment", "model", "3"]),
    "unknown parameter": (env("model='mass-spring-damper'\nmass='3 kg'"), ["environment", "mass", "m, b, k"]),
    "parameter missing": (env("model='maxwell'\nk=3"), ["environment", "b", "missing"]),
    "unknown evaluation key": (evaluation("jnds = 0.1"), ["evaluation", "jnds", "band, jnd"]),
    "effect name not a string": (f"{ENVIRONMENT}{FILTER}name = 3", ["effects[1]", "name", "3"]),
    "title not a string": (f"title = 3\n{ENVIRONMENT}", ["title", "3"]),
    # units and dimensions
    "unknown unit": (env("model='mass-spring-damper'\nm='3 stones'"), ["environment", "m", "stones", "kg"]),
    "wrong dimension": (env("model='mass-spring-damper'\nm='3 N'"), ["environment", "m", "3 N", "kg"]),
    "a stiffness in Hz": (env("model='mass-spring-damper'\nk='3 Hz'"), ["environment", "k", "3 Hz", "N/m"]),
    "mixed motions": (
        env("model='mass-spring-damper'\nm='3 kg'\nk='3 N*m/rad'"),
        ["environment.m", "environment.k", "rotational"],
    ),
    "unit with a power tower": (env("model='mass-spring-damper'\nm='3 kg^9^9^9'"), ["environment", "m", "kg^9^9^9"]),
    "code for a unit": (
        env("model='mass-spring-damper'\nm=\"3 __import__('os')\""),
        ["environment", "m", "__import__"],
    ),
    "unit alone": (env("model='mass-spring-damper'\nm='kg'"), ["environment", "m", "kg", "number"]),
    "empty value": (env("model='mass-spring-damper'\nm=''"), ["environment", "m", "number"]),
    "a list for a number": (
        env("model='mass-spring-damper'\nm=[1, 2, 3, 4]"),
        ["environment", "m", "[1, 2, 3, 4]", "pair"],
    ),
    "a nominal value outside its range": (
        env("model='mass-spring-damper'\nm=[1, 4, 3]"),
        ["environment", "m", "[1, 4, 3]", "between the other two"],
    ),
    "true for a number": (env("model='mass-spring-damper'\nm=true"), ["environment", "m", "m: true"]),
    "a date for a number": (env("model='mass-spring-damper'\nm=2019-01-01"), ["environment", "m", "2019-01-01"]),
    # values
    "negative mass": (env("model='mass-spring-damper'\nm='-3 kg'"), ["environment", "m", "-3 kg", ">= 0"]),
    "negative zeta": (
        f"{ENVIRONMENT}[[effects]]\nmodel='second-order-lowpass'\nomega_n=80\nzeta=-0.1",
        ["zeta", "-0.1", ">= 0"],
    ),
    "zero cut-off": (f"{ENVIRONMENT}[[effects]]\nmodel='first-order-lag'\nomega_c=0", ["omega_c", "0", "> 0"]),
    "nan": (env("model='mass-spring-damper'\nm=nan"), ["environment", "m", "NaN"]),
    "inf": (env("model='mass-spring-damper'\nm=inf"), ["environment", "m", "Infinity"]),
    "nan in a string": (env("model='mass-spring-damper'\nm='nan kg'"), ["environment", "m", "nan kg"]),
    "huge exponent": (
        env("model='mass-spring-damper'\nm='1e999999999 kg'"),
        ["environment", "m", "1e999999999", "300"],
    ),
    "division by zero in a number": (
        env("model='mass-spring-damper'\nm='1/0 kg'"),
        ["environment", "m", "1/0", "zero"],
    ),
    "nothing to feel": (env("model='mass-spring-damper'\nk=0"), ["zero at every frequency"]),
    "no parameter at all": (env("model='mass-spring-damper'"), ["environment", "m, b, k"]),
    "pade order": (f"{ENVIRONMENT}[[effects]]\nmodel='pade-delay'\ntau=1\norder=2.5", ["order", "2.5", "whole number"]),
    "lists of two lengths": (env("model='prony'\nk0=1\nk=[1,2]\nb=[1]"), ["environment", "k and b"]),
    "empty list": (env("model='prony'\nk0=1\nk=[]\nb=[]"), ["environment", "k", "list"]),
    "alpha above one": (env("model='spring-pot'\nk_alpha=1\nalpha=1.5"), ["environment", "alpha", "1.5", "0 and 1"]),
    # band and threshold
    "zero-length band": (evaluation("band = [3, 3]"), ["band", "3", "above"]),
    "reversed band": (evaluation("band = ['15 rad/s', '0 rad/s']"), ["band", "15", "above"]),
    "negative band": (evaluation("band = [-1, 3]"), ["band", "-1", ">= 0"]),
    "band of one": (evaluation("band = [1]"), ["band", "two"]),
    "band in seconds": (evaluation("band = ['0 s', '3 s']"), ["band", "0 s", "rad/s"]),
    "zero jnd": (evaluation("jnd = 0"), ["jnd", "0", "> 0"]),
    "negative jnd": (evaluation("jnd = { real = 0.1, imag = -0.1 }"), ["jnd", "imag", "-0.1", "> 0"]),
    "half a jnd": (evaluation("jnd = { real = 0.1 }"), ["jnd", "imag"]),
    # formulas
    "code": (expression("__import__('os').system('touch owned')"), ["environment", "H", "__import__"]),
    "attribute": (expression("m.real"), ["environment", "H", "."]),
    "call": (expression("exp(s)"), ["environment", "H", "exp"]),
    "unknown name": (expression("m*s^2 + x"), ["environment", "H", "x", "^"]),
    "unbalanced": (expression("(m*s^2"), ["environment", "H", ")"]),
    "dangling operator": (expression("m*s^2 +"), ["environment", "H", "the end"]),
    "huge degree": (expression("s^100000"), ["environment", "H", "100000"]),
    "power tower": (expression("((s^50)^50)^50"), ["environment", "H", "degree"]),
    "huge number": (expression("((9^999)^999)^999"), ["environment", "H", "digits"]),
    "deep parentheses": (expression("(" * 3000 + "s" + ")" * 3000), ["environment", "H"]),
    "deep signs": (expression("-" * 3900 + "s"), ["environment", "H", "nested"]),
    "long formula": (expression("+".join(["s"] * 5000)), ["environment", "H", "characters"]),
    "division by zero": (expression("1/(m - m)"), ["environment", "H", "zero"]),
    "formula missing": (env("model='expression'"), ["environment", "H", "missing"]),
    "a parameter called s": (
        env("model='expression'\nH='s'\nparameters={ s = 3 }"),
        ["environment", "s", "cannot name"],
    ),
    "parameters not a table": (env("model='expression'\nH='s'\nparameters=3"), ["environment", "parameters", "3"]),
    "two-port that is infinite": (
        f"{ENVIRONMENT}[[effects]]\nmodel='two-port'\nA='1'\nB='0'\nC='0'\nD='0'",
        ["infinite"],
    ),
    "shunt of two kinds": (f"{ENVIRONMENT}[[effects]]\nmodel='shunt'\nm=1\nZ='s'", ["effects[1]", "Z", "m, b, k"]),
}


@pytest.mark.parametrize("name", BAD)
def test_a_broken_scene_is_refused_with_one_message(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text, words = BAD[name]
    scene = tmp_path / "broken.toml"
    scene.write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["haptisym", "evaluate", "broken.toml", "--json"])
    started = time.perf_counter()
    with pytest.raises(SystemExit) as stop:
        main()
    seconds = time.perf_counter() - started
    out, err = capsys.readouterr()
    assert stop.value.code == 2
    assert out == ""
    assert err.startswith("error: ")
    assert len(err) < 1000
    assert "Traceback" not in err
    for word in ["broken.toml", *words]:
        assert word in err, f"{word!r} not in {err!r}"
    assert seconds < 10  # two on an idle machine; this only catches a hang
    assert sorted(p.name for p in tmp_path.iterdir()) == ["broken.toml"], "something was written"


@pytest.mark.parametrize(
    ("jnd", "told"),
    [
        ('"0.1 + f/100"', "a formula in omega (rad/s) and nothing else"),
        ('"2*0.05*x"', "a formula in omega (rad/s) and nothing else"),
        ("[0.2, 0.1]", "[0.2, 0.1]: the lower end"),
        ('["0.2", 0.1]', "[0.2, 0.1]: the lower end"),
    ],
)
def test_a_threshold_that_is_none_is_told_as_it_was_written(jnd: str, told: str) -> None:
    with pytest.raises(SceneError) as raised:
        parse_scene(f'[environment]\nmodel = "kelvin-voigt"\nk = 1\nb = 1\n[evaluation]\njnd = {jnd}\n')
    assert told in str(raised.value)
    assert "Decimal" not in str(raised.value)


def test_a_file_of_ten_megabytes_is_refused_unread(tmp_path: Path) -> None:
    scene = tmp_path / "large.toml"
    scene.write_bytes(b"# " + b"x" * 10_000_000)
    with pytest.raises(SceneError, match=r"large\.toml.*at most"):
        load_scene(scene)


def test_a_file_that_is_not_text_is_refused(tmp_path: Path) -> None:
    scene = tmp_path / "image.toml"
    scene.write_bytes(b"\x89PNG\xff\xfe\x00")
    with pytest.raises(SceneError, match="not a text file"):
        load_scene(scene)


@pytest.mark.parametrize("name", ["nosuch", "fu2018", "no/such/file.toml", ".", "\0"])
def test_a_scene_that_is_not_there_is_named_and_others_are_offered(name: str) -> None:
    with pytest.raises(SceneError) as error:
        load_scene(name)
    assert "fu2019" in str(error.value)


def test_a_misspelt_scene_gets_a_suggestion() -> None:
    with pytest.raises(SceneError, match='did you mean "fu2019"'):
        load_scene("fu2091")


def test_an_error_in_a_formula_points_at_the_place() -> None:
    with pytest.raises(SceneError) as error:
        parse_scene(expression("m*s^2 + x*s"))
    lines = str(error.value).splitlines()
    assert lines[-2][lines[-1].index("^")] == "x"


SMALL = 'environment = { model = "maxwell", k = 100, b = 5 }\n'


def test_a_number_may_have_two_hundred_characters_and_no_more() -> None:
    digits = "1." + "3" * 198
    scene = parse_scene(f'environment = {{ model = "mass-spring-damper", k = "{digits} N/m" }}')
    assert Rational(digits) == scene.environment.H
    with pytest.raises(SceneError, match="at most 200 characters"):
        parse_scene(f'environment = {{ model = "mass-spring-damper", k = "{digits}3 N/m" }}')


@pytest.mark.parametrize(
    ("formula", "at"), [("m*s^2^3", 5), ("m*s^(10^9)", 7), ("m*(s + exp(-s))", 7), ("1/(m - m)", 1), ("m*s + x", 6)]
)
def test_the_mark_stands_under_what_is_wrong(formula: str, at: int) -> None:
    with pytest.raises(SceneError) as refused:
        parse_scene(expression(formula))
    _, shown, mark = str(refused.value).split("\n")
    assert (shown.strip(), mark.index("^") - 4) == (formula, at)


def test_a_byte_order_mark_is_no_part_of_a_scene(tmp_path: Path) -> None:
    marked = tmp_path / "marked.toml"
    marked.write_text(SMALL, encoding="utf-8-sig")
    assert load_scene(marked) == parse_scene(SMALL) == parse_scene("\ufeff" + SMALL)


def test_a_file_in_utf_16_is_said_to_be_one(tmp_path: Path) -> None:
    wide = tmp_path / "wide.toml"
    wide.write_text(SMALL, encoding="utf-16")
    with pytest.raises(SceneError, match=r"wide.toml: the file is written in UTF-16: save it as UTF-8"):
        load_scene(wide)


@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="pipes have names on POSIX")
def test_a_scene_is_read_once_so_that_it_may_come_from_a_pipe(capsys, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    families = SMALL.replace("environment = ", "environments = [").rstrip() + "]\n"
    for words, text in ((["evaluate"], SMALL), (["sensitivity"], SMALL), (["evaluate"], families)):
        reading, writing = os.pipe()
        os.write(writing, text.encode())
        os.close(writing)
        monkeypatch.setattr("sys.argv", ["haptisym", *words, f"/dev/fd/{reading}"])
        with pytest.raises(SystemExit) as stop:
            main()
        os.close(reading)
        assert not stop.value.code, capsys.readouterr()


def test_a_pipe_with_a_wrong_scene_and_a_device_without_end_are_named(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=lambda: pipe.write_text("k = 1", encoding="utf-8"))
    writer.start()
    with pytest.raises(SceneError, match=rf'{pipe}: unknown key "k"'):
        load_scene(pipe)
    writer.join()
    with pytest.raises(SceneError, match="/dev/zero: the file has more than 1000000 bytes"):
        load_scene("/dev/zero")


def test_a_file_that_is_too_long_is_not_taken_for_another_name(tmp_path: Path) -> None:
    big = tmp_path / "big.toml"
    big.write_text("#" * 1_000_001, encoding="utf-8")
    with pytest.raises(SceneError) as refused:
        load_scene(big)
    assert str(refused.value) == f"{big}: the file has more than 1000000 bytes; a scene may have at most that"


def test_a_name_without_its_ending_is_asked_about(tmp_path: Path) -> None:
    (tmp_path / "ok.toml").write_text(SMALL, encoding="utf-8")
    (tmp_path / "other.toml").write_text(SMALL, encoding="utf-8")
    with pytest.raises(SceneError, match=r'did you mean "ok.toml"\?'):
        load_scene(tmp_path / "ok")


@pytest.mark.parametrize("text", ["omega,real,imag\n1,2,3\n", "# from the bench\nlevel;k;n\n1;2;3\n", "1\t2\t3\n"])
def test_a_table_of_lines_is_told_where_it_belongs(text: str) -> None:
    with pytest.raises(SceneError, match=r"^it: a table of lines and no scene: .* \[perceived\]; haptisym identify"):
        parse_scene(text, "it")
