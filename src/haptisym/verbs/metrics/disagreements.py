"""Where measures of transparency and the JND verdict disagree, in sentences."""

from __future__ import annotations

from collections.abc import Iterable

from haptisym.verbs.metrics.measured import Bands, Measured, covers

_BLIND = (
    "A force filter or delay in series leaves the zeros of the dynamics where they are: a free-response test sees of it only how "
    "the motion begins, while the JND test sees all."
)
_SLACK = "The free response keeps its tolerances although a moving hand notices the distortion on this band."
_STRICT = "The free response breaks its tolerances although no moving hand notices anything on this band."
_COARSE = (
    "The transmitted impedance stays within 3 dB on the whole band on which the JND is exceeded: 3 dB is 29 to 41 % of the "
    "modulus, far more than the threshold, and does not see the phase."
)
_ACTIVE = (
    "Transparent is not absolutely stable: the conditions on the axis fail on all of the band but single frequencies, so that "
    "some passive hand or environment could draw energy from this display where nothing is noticed."
)


def disagreements(m: Measured) -> Iterable[str]:
    """What one measure says and another does not, in sentences."""
    e = m.evaluation
    noticed = e.bandwidth is not e.chart.points[-1].omega
    if noticed and m.free.blind:
        yield _BLIND
    elif noticed and m.free.passes:
        yield _SLACK
    elif not noticed and m.free.passes is False:
        yield _STRICT
    if noticed and covers(m.inside, e.chart):
        yield _COARSE
    if e.transparent and m.llewellyn is not None and _only_points(m.llewellyn):
        yield _ACTIVE


def _only_points(bands: Bands) -> bool:
    """Whether a set holds single frequencies at most."""
    return all(x.low is x.high for x in bands)
