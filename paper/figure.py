"""The figure of the paper, ``ratios.png``: the first step of the evaluation of Fu, van Paassen and Mulder (2019)."""

from pathlib import Path

import haptisym as hs

hs.evaluate("fu2019").save_figure(Path(__file__).with_name("ratios.png"))
