"""What the force before a clock cancels remains a mode of what moves: held against a state space in which nothing cancels."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import haptisym as hs
from haptisym.verbs.stability.held import held


@dataclass(frozen=True)
class Hidden:
    """A mass M with s^2 + c s + d = (s - p)(s - q), felt through a hold as g (s - p)(s + a)/((s + e)(s + f)), or with a pair in both."""

    M: int
    moving: tuple[int, int]  # c, d, in eighths
    above: tuple[int, int]  # s^2 + ..., in eighths
    below: tuple[int, int]
    gain: int
    T: int  # ms
    on: int  # roots that the clock does not see on the circle

    @classmethod
    def drawn(cls, seed: int) -> Hidden:
        pick = random.Random(seed)
        p, e, f, a = pick.choice([0, 0, -1, 1, 2]), pick.randint(2, 9), pick.randint(10, 30), pick.randint(3, 20)
        if pick.random() < 0.3:  # s^2 + 4 in both
            moving, above, on = (0, 32), (0, 32), 2
        else:
            q = -pick.randint(1, 8)
            moving, above, on = (-8 * (p + q), 8 * p * q), (8 * (a - p), -8 * a * p), int(p == 0)
        return cls(
            pick.randint(1, 3), moving, above, (8 * (e + f), 8 * e * f), pick.randint(1, 60), pick.randint(5, 40), on
        )

    @property
    def scene(self) -> hs.Scene:
        (n1, n0), (d1, d0), (c, d) = self.above, self.below, self.moving
        felt = f"{self.gain}*(s^2 + {n1}/8*s + {n0}/8)/(s^2 + {d1}/8*s + {d0}/8)".replace("+ -", "- ")
        text = (
            f'[environment]\nmodel = "expression"\nH = "{felt}"\n[[effects]]\nmodel = "zero-order-hold"\nT = "{self.T} ms"\n'
            f'[[effects]]\nmodel = "shunt"\nm = {self.M}\nb = "{self.M * c}/8"\nk = "{self.M * d}/8"\n'
            "[hand]\nm = 0\n[evaluation]\nband = [0, 15]\n"
        )
        return hs.parse_scene(text)

    def sizes(self) -> Any:
        """|z| of position, velocity and the two states of the force, sampled exactly; the force of the last sample is held."""
        (n1, n0), (d1, d0), (c, d) = (np.array(x) / 8 for x in (self.above, self.below, self.moving))
        continuous = np.zeros((5, 5))  # x, v, y, y', and the force that is held
        continuous[0, 1] = continuous[2, 3] = 1
        continuous[1, :2], continuous[1, 4] = (-d, -c), -1 / self.M
        continuous[3, 0], continuous[3, 2:4] = 1, (-d0, -d1)
        over = expm(continuous * self.T / 1000)
        force = self.gain * np.array([1, 0, n0 - d0, n1 - d1])
        return np.abs(np.linalg.eigvals(over[:4, :4] + np.outer(over[:4, 4], force)))

    def is_clear(self) -> bool:
        """Whether floats tell all other roots from the circle."""
        return bool((np.sort(np.abs(self.sizes() - 1))[self.on :] > 1e-5).all())


@pytest.mark.few(12)
@pytest.mark.parametrize("seed", range(40))
def test_roots_are_those_of_the_whole_loop(seed: int) -> None:
    case = next(x for x in (Hidden.drawn(seed + 100 * n) for n in range(50)) if x.is_clear())
    assert (np.sort(np.abs(case.sizes() - 1))[: case.on] < 1e-7).all()
    found = held(case.scene, case.scene.hands[0])
    assert case.on == 2 or found.stable is not None
    assert found.unstable in (np.count_nonzero(case.sizes() > 1 - 1e-6), None)


@pytest.mark.slow
def test_a_damper_in_series_with_a_spring_holds_no_handle_also_behind_a_hold() -> None:
    """m s^2 + b s + H_perc(s) vanishes at s = 0: one root at z = 1, as without the hold; no damping of a hand mends it."""
    text = (
        '[environment]\nmodel = "maxwell"\nk = "100 N/m"\nb = "5 N*s/m"\n{}[hand]\nm = "1 kg"\nb = "1 N*s/m"\nk = 0\n'
    )
    late = hs.parse_scene(text.format('[[effects]]\nmodel = "zero-order-hold"\nT = "5 ms"\n'))
    plain = hs.parse_scene(text.format(""))
    assert [hs.stability(x).held[0].unstable for x in (late, plain)] == [1, 1]
    assert hs.require(late, "hand.b", ("0.1", "20"), that=("stable",)).feasible == ()


def test_a_handle_without_mass_damping_and_stiffness_at_the_end_of_a_search_ends_no_answer() -> None:
    felt, loop = hs.environments.expression("1.2 + s/2"), hs.effects.sampled_loop("1 s", "backward-difference")
    found = hs.stability(hs.Scene(felt, (loop,), hands=(hs.Hand("mover", b=1),)))
    assert found.held[0].unstable is not None


def test_what_binds_a_sampled_loop_lies_on_the_unit_circle() -> None:
    """b of a centring spring at 60 Hz, one frame late, on a wheel of 0.04 kg m^2 and 0.1 N m s/rad: by eigenvalues."""
    text = (
        '[environment]\nmodel = "kelvin-voigt"\nk = 8\nb = 0\n[[effects]]\nmodel = "sampled-loop"\nT = "16.6666666667 ms"\n'
        'method = "backward-difference"\ndelay = 1\n[[effects]]\nmodel = "shunt"\nm = 0.04\nb = 0.1\n[hand]\nm = 0\n'
    )
    found = hs.require(hs.parse_scene(text), "environment.b", that=("stable",))
    [span] = found.feasible
    assert (span.low.value.digits(15), span.high.value.digits(15)) == ("0.107766452952012", "1.87491415916525")
    assert "unit circle" in str(found)
    assert "imaginary axis" not in str(found)
