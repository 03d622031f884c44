"""Named steps are worth what their program is worth, at any stage, and say what a reader would."""

from __future__ import annotations

import pytest
from sympy import Integer, Rational, Symbol, cos, sin, symbols

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega
from haptisym.programs.closed import closed_program
from haptisym.programs.program import Writer
from haptisym.programs.steps import Steps, code_steps, page_steps

a, b, x0 = symbols("a b x0")


def written(expression, label=""):
    """A program of one expression in a and b."""
    write = Writer((a, b, x0))
    step = write.expression(expression)
    return write, write.label(step, label) if label else step


def test_an_operation_in_a_definition_is_counted_once():
    steps = Steps(((b, cos(a) + 1),), {"y": b * b + b, "z": 2 * b})
    assert steps.operations == 2 + 2 + 1


def test_definitions_are_put_into_later_definitions():
    c = Symbol("c")
    assert Steps(((b, a + 1), (c, b**2)), {"y": c + b}).at({}) == {"y": (a + 1) ** 2 + a + 1}


@pytest.mark.parametrize("definitions", [((a, b), (b, x0)), ((a, a + 1),), ((a, x0), (a, b))])
def test_a_name_is_defined_once_and_before_its_use(definitions):
    with pytest.raises(hs.SceneError, match=r"before its definition|twice"):
        Steps(definitions, {})


def test_some_results_need_some_definitions_and_none_for_a_mere_result():
    c, d, e = symbols("c d e")
    steps = Steps(((c, a + 1), (d, c * b), (e, b**2)), {"x": d, "y": e, "z": c + e})
    assert steps.only(["x"]) == Steps(((c, a + 1),), {"x": c * b})
    assert steps.only(["y", "z"]) == Steps(((c, a + 1), (e, b**2)), {"y": e, "z": c + e})


@pytest.mark.parametrize("read", [code_steps, page_steps])
def test_a_label_is_the_name_of_a_step_that_others_use(read):
    write, total = written(a + b, "S")
    steps = read(write.program({"x": write.mul(total, total), "y": total}))
    S = Symbol("S", real=True)
    assert steps == Steps(((S, a + b),), {"x": S**2, "y": S})
    assert not read(write.program({"y": total})).definitions


@pytest.mark.parametrize("read", [code_steps, page_steps])
def test_a_label_on_a_negative_names_the_negative(read):
    write, product = written(a * b)
    negative = write.label(write.neg(product), "P")
    steps = read(write.program({"x": write.mul(negative, write.input(x0)), "y": write.add(write.input(x0), product)}))
    P = Symbol("P", real=True)
    assert steps == Steps(((P, -a * b),), {"x": P * x0, "y": x0 - P})


@pytest.mark.parametrize("read", [code_steps, page_steps])
def test_the_opposite_of_a_named_difference_is_not_computed_again(read):
    write, change = written(a - b, "D")
    other = write.mul(write.neg(change), write.input(x0))
    D = Symbol("D", real=True)
    assert read(write.program({"x": other, "y": write.mul(change, change)})) == Steps(
        ((D, a - b),), {"x": -D * x0, "y": D**2}
    )


def test_a_defined_name_is_never_one_of_the_arguments():
    write, total = written(x0 + a, "b")
    steps = code_steps(write.program({"y": write.mul(total, total), "z": write.sqrt(write.expression(a - b))}))
    names = [name.name for name, _ in steps.definitions]
    assert names == ["bx", "x1"]
    assert steps.at({x0: Integer(1), a: Integer(2), b: Integer(1)}) == {"y": 9, "z": 1}


def test_a_page_has_whole_angles_and_code_has_their_halves():
    half = a / 2
    write, change = written(-2 * sin(half) ** 2, "P")
    program = write.program({"y": write.mul(change, write.input(b))})
    [(P, whole)], [*_, (_, halves)] = page_steps(program).definitions, code_steps(program).definitions
    assert (P.name, whole) == ("P", cos(a) - 1)
    assert not halves.has(cos)
    at = {a: Rational(7, 5), b: Integer(3)}
    one, two = (read(program).at(at)["y"] for read in (code_steps, page_steps))
    assert abs((one - two).evalf(30)) < 1e-25


def test_what_is_short_and_has_no_label_has_a_name_in_code_alone():
    write, square = written(a**2)
    program = write.program({"x": write.add(square, write.input(b)), "y": write.mul(square, write.input(b))})
    assert page_steps(program) == Steps((), {"x": a**2 + b, "y": a**2 * b})
    assert len(code_steps(program).definitions) == 1


@pytest.mark.parametrize("n", range(8))
@pytest.mark.parametrize("dynamics", [(), (hs.s**2 + 3 * hs.s + 5,)])
def test_the_root_of_a_closed_form_squares_to_it(n, dynamics):
    """Of a squared modulus, with its sum of squares or without, and of a power that only even ones make positive."""
    ring = Ring.of([hs.s])
    square = RealFunction(
        ring.axis.convert(((5 - omega**2) ** 2 + 9 * omega**2) ** n * (omega - 2) ** 2 / (omega**2 + 1) ** n)
    )
    program = closed_program({"ratio": square}, [ring.convert(x).numerator for x in dynamics], ())
    at = {omega: Rational(3, 2)}
    assert code_steps(program).at(at)["ratio"] ** 2 == square.expression().xreplace(at)
    assert code_steps(program).at(at)["ratio"] > 0
