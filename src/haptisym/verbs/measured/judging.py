"""Three-valued judgements of measured lines: where the disc of a change lies against the region of what is not noticed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from haptisym.judge.percepts import Change, Property, real_property
from haptisym.kernel.errors import SceneError
from haptisym.model.catalogue import Environment
from haptisym.model.jnd import Part, Threshold
from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.measuredscene import MeasuredScene
from haptisym.verbs.measured.regions import ends_of, floor_of, is_of_change_alone, joint_distance, part_distance

OPEN = 2
"""A sign that a disc does not tell."""


class Verdict(Enum):
    """Of a part at a line."""

    EXCEEDS = "exceeds"
    BELOW = "below"
    UNRESOLVED = "unresolved"


CODES = {1: Verdict.EXCEEDS, -1: Verdict.BELOW, 0: Verdict.UNRESOLVED}


@dataclass(frozen=True, eq=False)
class Lines:
    """The measured lines as numbers: both responses, the radii of their discs, and the change with its own.

    ``environment``, ``perceived`` : H at ``omega``, rad/s. ``env_radius``, ``perc_radius`` : in the unit of H, 0 where a response
    is taken as it is. ``change`` : dH/|H_env|, x + j y. ``radius`` : of a disc around it that holds the true change, relative
    to the true ``|H_env|``, whenever both discs hold the truth; None where no disc is known. ``felt``, ``own`` : as
    they were measured; ``own`` is of the environment, None where that is a model.
    """

    omega: Reals
    environment: Complexes
    perceived: Complexes
    env_radius: Reals
    perc_radius: Reals
    change: Complexes
    radius: Reals | None
    felt: Measurement
    own: Measurement | None


def matched(scene: MeasuredScene) -> tuple[Measurement, Measurement | None]:
    """The perceived response on the band, and the environment's where that is measured, at the same frequencies. SceneError
    where there are none."""
    felt, own = scene.perceived, scene.environment
    if scene.band is not None:
        felt = felt.on_band(*map(float, scene.band))
    if isinstance(own, Environment):
        return felt, None
    nearest = _nearest(own.omega, felt.omega)
    common = np.abs(own.omega[nearest] - felt.omega) <= _SAME * felt.omega
    if not common.any():
        raise SceneError(f"{own.name} and {felt.name} have no frequency in common: lines are compared one by one")
    return felt.at(common), own.at(nearest[common])


_SAME = 1e-9
"""Frequencies that differ by no more than this share are one: files round them."""


def _nearest(among: Reals, wanted: Reals) -> Any:
    """For each wanted frequency the index of the nearest one among rising others."""
    right = np.searchsorted(among, wanted).clip(0, len(among) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(wanted - among[left] <= among[right] - wanted, left, right)


def lines_of(scene: MeasuredScene) -> Lines:
    """The lines that a scene judges. SceneError where H_env is infinite at one of them."""
    felt, own = matched(scene)
    env = _exact(scene, felt.omega) if own is None else own.H
    none = np.broadcast_to(0.0, len(felt))
    inner, outer = (none if m is None or m.discs is None else m.discs for m in (own, felt))
    known = any(m is not None and m.discs is not None for m in (own, felt))
    size = np.abs(env)
    with np.errstate(divide="ignore", invalid="ignore"):
        change = (felt.H - env) / size
        share = inner / size
        radius = np.where(share < 1, ((inner + outer) / size + np.abs(change) * share) / (1 - share), np.inf)
    return Lines(felt.omega, env, felt.H, inner, outer, change, radius if known else None, felt, own)


def _exact(scene: MeasuredScene, at: Reals) -> Complexes:
    """H_env of a model, at all frequencies."""
    values = scene.frame.distortion().compile(of=["environment_real", "environment_imag"])(at)
    with np.errstate(invalid="ignore"):  # of what is infinite
        env: Complexes = values.environment_real + 1j * values.environment_imag
    if not np.isfinite(env).all():
        where = at[int(np.argmin(np.isfinite(env)))]
        raise SceneError(
            f"H_env is infinite at {where:.6g} rad/s: nothing can be compared with it; leave that line out"
        )
    return env


# Step 1.


def limits_of(scene: MeasuredScene, at: Reals) -> dict[Part, Reals]:
    """Of both parts the lesser of the two limits within which a change of that part alone is not noticed."""
    ends = {part: ends_of(scene.threshold, part, at) for part in Part}
    return {part: np.minimum(-low, high) for part, (low, high) in ends.items()}


@dataclass(frozen=True, eq=False)
class Judged:
    """``distance`` : how far, relative to ``|H_env|``, a line's change lies outside the region, negative inside; ``verdict`` : 1
    where the whole disc lies outside, -1 where it lies inside, 0 where it does not tell."""

    distance: Reals
    verdict: Any


def judged(scene: MeasuredScene, x: Lines, part: Part | None) -> Judged | None:
    """Of a part by itself, or of both together: None where the region judges each by itself."""
    c = scene.threshold
    with np.errstate(divide="ignore", invalid="ignore"):
        if part is None:
            distance = joint_distance(c, x.omega, x.change.real, x.change.imag)
            if distance is None:
                return None
        else:
            own = _side(x.change, part)
            env, reach = (own, (own, own)) if is_of_change_alone(c, part) else _environment(x, part)  # or not looked at
            distance = part_distance(c, part, x.omega, own, env, reach)
    return _told(x, distance, part, c)


def _side(z: Complexes, part: Part) -> Reals:
    return z.real if part is Part.REAL else z.imag


def _environment(x: Lines, part: Part) -> tuple[Reals, tuple[Reals, Reals]]:
    """Its part as a share of ``|H_env|``, and the least and the largest ``|H_env|`` in its disc."""
    size = np.abs(x.environment)
    return _side(x.environment, part) / size, (np.maximum(size - x.env_radius, 0), size + x.env_radius)


def _told(x: Lines, distance: Reals, part: Part | None, c: Threshold) -> Judged:
    """Where H_env is 0, what of dH is judged is compared with the floor."""
    zero = (x.environment == 0) & (x.env_radius == 0)
    is_any = bool(zero.any())
    if is_any:
        dH = x.perceived - x.environment
        moved, floor = np.abs(_side(dH, part) if part else dH), floor_of(c, x.omega)
        distance = np.where(zero, np.where(moved <= floor, -np.inf, np.inf), distance)
    with np.errstate(invalid="ignore"):
        radius = 0.0 if x.radius is None else x.radius
        outside, inside = distance > radius, distance <= -radius
    if is_any:
        outside = np.where(zero, moved > x.perc_radius + floor, outside)
        inside = np.where(zero, moved + x.perc_radius <= floor, inside)
    return Judged(distance, outside.astype(np.int8) - inside.astype(np.int8))


# Step 2.


@dataclass(frozen=True, eq=False)
class Signs:
    """What discs tell of a part: its signs in H_env and H_perc, and whether it is felt larger; OPEN where they do not."""

    environment: Any
    perceived: Any
    compared: Any

    @property
    def known(self) -> Any:
        """Where all are told."""
        return (self.environment != OPEN) & (self.perceived != OPEN) & (self.compared != OPEN)

    def label(self, part: Part, line: int) -> tuple[Property, Change]:
        """How the change is felt at a line where all signs are known."""
        env, perc, compared = int(self.environment[line]), int(self.perceived[line]), int(self.compared[line])
        change = {1: Change.HIGHER, -1: Change.LOWER, 0: Change.EQUAL}[compared]
        return (Property.DAMPING if part is Part.IMAG else real_property(env, perc)), change


def signs(x: Lines, part: Part) -> Signs:
    """Of one part, at all lines."""
    env, perc = (h.real if part is Part.REAL else h.imag for h in (x.environment, x.perceived))
    compared = _sign(np.abs(perc) - np.abs(env), x.env_radius + x.perc_radius)
    return Signs(_sign(env, x.env_radius), _sign(perc, x.perc_radius), compared)


def _sign(value: Reals, radius: Reals) -> Any:
    told: Any = np.where((np.abs(value) > radius) | (radius == 0), np.sign(value), OPEN)
    return told.astype(np.int8)


def certainty(m: Measurement) -> str:
    """What the discs of a response come from."""
    if m.coherence is not None:
        return f"coherence, {m.averages:g} averages"
    return "no disc is known" if m.radius is None else "radius in the file"
