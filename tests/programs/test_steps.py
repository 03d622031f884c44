"""Named steps are worth what their program is worth, at any stage, and say what a reader would."""

from __future__ import annotations

import re
from contextlib import suppress
from fractions import Fraction
from operator import add, mul, neg, sub, truediv
from random import Random

import pytest
from flint import fmpq
from sympy import Rational, Symbol, cos, sin, symbols

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega
from haptisym.programs.closed import closed_program
from haptisym.programs.program import Writer
from haptisym.programs.steps import Steps, page_steps
from haptisym.writing.code.expressions import DIALECTS, CodeReader
from haptisym.writing.code.names import Language

a, b, x0 = symbols("a b x0")


def written(expression, label=""):
    """A program of one expression in a and b."""
    write = Writer((a, b, x0))
    step = write.expression(expression)
    return write, write.label(step, label) if label else step


def in_code(program):
    """The definitions and the results in Python."""
    names = {x: x.name for x in program.inputs}
    reader = CodeReader(program, {*names.values()}, dialect=DIALECTS[Language.NUMPY], names=names)
    results = reader.results()
    return {x: y.text for x, y in reader.definitions}, {x: y.text for x, y in results.items()}


def test_an_operation_in_a_definition_is_counted_once():
    steps = Steps(((b, cos(a) + 1),), {"y": b * b + b, "z": 2 * b})
    assert steps.operations == 2 + 2 + 1


def test_a_fraction_is_one_number_and_a_whole_exponent_stays_one():
    a = Symbol("a")
    for value, count in (
        (a / 3, 1),
        (Rational(2, 3) * a, 1),
        (1 / a**2, 2),
        (2 * a, 1),
        (-a, 1),
    ):
        assert Steps((), {"y": value}).operations == count


def test_definitions_are_put_into_later_definitions():
    c = Symbol("c")
    assert Steps(((b, a + 1), (c, b**2)), {"y": c + b}).at({}) == {"y": (a + 1) ** 2 + a + 1}


def test_some_results_need_some_definitions_and_none_for_a_mere_result():
    c, d, e = symbols("c d e")
    steps = Steps(((c, a + 1), (d, c * b), (e, b**2)), {"x": d, "y": e, "z": c + e})
    assert steps.only(["x"]) == Steps(((c, a + 1),), {"x": c * b})
    assert steps.only(["y", "z"]) == Steps(((c, a + 1), (e, b**2)), {"y": e, "z": c + e})


def test_a_label_is_the_name_of_a_step_that_others_use():
    write, total = written(a + b, "S")
    program = write.program({"x": write.mul(total, total), "y": total})
    S = Symbol("S", real=True)
    assert page_steps(program) == Steps(((S, a + b),), {"x": S**2, "y": S})
    assert in_code(program) == ({"S": "a + b"}, {"x": "S*S", "y": "S"})
    alone = write.program({"y": total})
    assert page_steps(alone) == Steps((), {"y": a + b})
    assert in_code(alone) == ({}, {"y": "a + b"})


def test_a_label_on_a_negative_names_the_negative():
    write, product = written(a * b)
    negative = write.label(write.neg(product), "P")
    program = write.program({"x": write.mul(negative, write.input(x0)), "y": write.add(write.input(x0), product)})
    P = Symbol("P", real=True)
    assert page_steps(program) == Steps(((P, -a * b),), {"x": P * x0, "y": x0 - P})
    assert in_code(program) == ({"P": "-a*b"}, {"x": "P*x0", "y": "x0 - P"})


def test_the_opposite_of_a_named_difference_is_not_computed_again():
    write, change = written(a - b, "D")
    program = write.program({"x": write.mul(write.neg(change), write.input(x0)), "y": write.mul(change, change)})
    D = Symbol("D", real=True)
    assert page_steps(program) == Steps(((D, a - b),), {"x": -D * x0, "y": D**2})
    assert in_code(program) == ({"D": "a - b"}, {"x": "-D*x0", "y": "D*D"})


def test_a_defined_name_is_never_one_of_the_arguments():
    write, total = written(x0 + a, "b")
    root = write.sqrt(write.expression(a - b))
    program = write.program({"y": write.mul(total, total), "z": write.add(root, write.div(write.input(a), root))})
    definitions, results = in_code(program)
    assert definitions.keys() == {"bx", "x1"}
    assert results["y"] == "bx*bx"
    assert {x.name for x, _ in page_steps(program).definitions} == {"bx"}


def test_a_page_has_whole_angles_and_code_has_their_halves():
    write, change = written(-2 * sin(a / 2) ** 2, "P")
    program = write.program({"y": write.mul(change, write.input(b))})
    [(P, whole)] = page_steps(program).definitions
    assert (P.name, whole) == ("P", cos(a) - 1)
    assert "cos" not in str(in_code(program))


def test_what_is_short_and_has_no_label_has_a_name_in_code_alone():
    write, square = written(a**2)
    program = write.program({"x": write.add(square, write.input(b)), "y": write.mul(square, write.input(b))})
    assert page_steps(program) == Steps((), {"x": a**2 + b, "y": a**2 * b})
    assert in_code(program)[0] == {"x1": "a*a"}


def test_code_has_brackets_enough():
    """Programs of random operations, run by fractions, and their code evaluated as Python with fractions for numbers."""
    run = {"add": add, "sub": sub, "mul": mul, "div": truediv, "neg": neg, "abs": abs}
    for seed in range(400):
        chance, write = Random(seed), Writer((a, b, x0))
        steps = [*map(write.input, (a, b, x0)), write.constant(2), write.constant(fmpq(-1, 4))]
        for _ in range(12):
            operation = chance.choice(list(run))
            chosen = [chance.choice(steps) for _ in range(1 if operation in ("neg", "abs") else 2)]
            steps.append(getattr(write, operation)(*chosen))
        program = write.program({"y": steps[-1]})
        definitions, results = in_code(program)
        known = {"a": Fraction(3, 7), "b": Fraction(-5, 3), "x0": Fraction(11, 2)}
        inputs, values = list(known.values()), []
        with suppress(ZeroDivisionError):
            for step in program.operations:
                if step.name == "input":
                    values.append(inputs[step.arguments[0]])
                elif step.name == "constant":
                    values.append(Fraction(repr(float(Fraction(int(step.value.p), int(step.value.q))))))
                else:
                    values.append(run[step.name](*(values[x] for x in step.arguments)))
            for name, text in {**definitions, **results}.items():
                known[name] = evaluated(text, known)
            assert known["y"] == values[program.results["y"]], (seed, definitions, results)


def evaluated(text, known):
    """Python's own value of an expression, its numbers taken as fractions."""
    exact = re.sub(r"(?<![\w.])\d+\.?\d*(e[+-]?\d+)?", r"Fraction('\g<0>')", text.replace("np.abs", "abs"))
    return eval(exact, {"Fraction": Fraction, "abs": abs}, known)  # noqa: S307 - our own code


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
    found = page_steps(program).at(at)["ratio"]
    assert found > 0
    assert found**2 == square.expression().xreplace(at)
