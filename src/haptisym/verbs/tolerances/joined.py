"""The largest of the smallest of functions over cells, as far as its sign and its zeros go, in one Taylor model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptisym.programs.taylormodels import Array, Model


def joined(terms: Sequence[Sequence[Model]]) -> Model:
    """A model with the sign and the zeros of max over ``terms`` of the min over each.

    In a cell only those functions count whose sign is not known there while it decides that of the whole. The model encloses
    each of them, value and slopes: a slope that keeps its sign is that of all of them, and so of what they make. Where none
    counts it is a number of the known sign.
    """
    signs = [[_sign(f) for f in term] for term in terms]
    alive = [np.logical_and.reduce([sign >= 0 for sign in term]) for term in signs]
    positive = np.logical_or.reduce([np.logical_and.reduce([sign > 0 for sign in term]) for term in signs])
    first = terms[0][0]
    found, known = first.number(1.0).where(positive, first.number(-1.0)), np.zeros(len(positive), dtype=bool)
    for own, term, of_term in zip(alive, terms, signs, strict=True):
        for f, sign in zip(term, of_term, strict=True):
            counts = own & (sign == 0) & ~positive
            found = f.where(counts & ~known, enclosing(found, f).where(counts & known, found))
            known |= counts
    return found


def _sign(f: Model) -> Array:
    """Of the value: 0 where it is not known."""
    low, high = (x[:, 0] for x in f.bounds())
    return np.where(low > 0, 1, np.where(high < 0, -1, 0))


def enclosing(f: Model, g: Model) -> Model:
    """A model within which both lie, with their slopes."""
    middle = [(a + b) / 2 for a, b in zip(f.arrays[:3], g.arrays[:3], strict=True)]
    c0, c1, c2 = (np.abs(a - b) / 2 for a, b in zip(f.arrays[:3], g.arrays[:3], strict=True))
    r = (c0 + Model(c0, c1, c2, np.maximum(f.r, g.r)).deviation) * (1 + 1e-14)
    return Model(middle[0], middle[1], middle[2], r + 1e-14 * (np.abs(middle[0]) + np.abs(f.c0)))
