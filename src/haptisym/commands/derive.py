"""The verb ``haptisym derive``: the formulas of a scene."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import click

from haptisym.commands.options import (
    given,
    json_option,
    keep_pages,
    say,
    say_document,
    scene_argument,
    verb,
    within_limit,
    write,
)
from haptisym.kernel.errors import SceneError
from haptisym.model.scene import Scene

if TYPE_CHECKING:
    from haptisym.verbs.derive.derivation import Derivation

_CODE = ("numpy", "python", "c", "octave", "javascript")
_OUTPUTS = ("text", "latex", "mathml", "json", "sympy", *_CODE)
_MEANT = {"matlab": "MATLAB runs --to octave", "julia": "for Julia: --to c, which ccall runs"}


class _Language(click.Choice[str]):
    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        if value in _MEANT:
            self.fail(_MEANT[value], param, ctx)
        return super().convert(value, param, ctx)


@verb()
@scene_argument
@click.option("--symbolic", "mode", flag_value="symbolic", help="Keep every parameter a symbol (default).")
@click.option("--numeric", "mode", flag_value="numeric", help="Insert the number of the scene for every parameter.")
@click.option(
    "--keep",
    "keep",
    multiple=True,
    metavar="NAME",
    help="Keep only this parameter a symbol, by path or name; repeatable.",
)
@click.option(
    "--to", "language", type=_Language(_OUTPUTS), default="text", show_default=True, help="Language of the output."
)
@click.option("--of", "names", multiple=True, metavar="QUANTITY", help="Print only this quantity; repeatable.")
@json_option
@within_limit
def derive(
    scene: Scene,
    mode: str | None,
    keep: tuple[str, ...],
    language: str,
    names: tuple[str, ...],
    as_json: bool,
) -> None:
    """Derive the formulas of a scene, as text, LaTeX or code.

    SCENE is a scene file (TOML) or the name of a shipped scene.

    Quantities for --of: H_env, H_perc, dH, Re dH, Im dH, |H_env|^2, r_r, r_i, Re(dH/H_env), Im(dH/H_env), the threshold
    polynomials p_r and p_i, the perceived properties k_env, m_env, b_env, k_perc, m_perc, b_perc, the force phasors F_si_env,
    F_d_env, F_si_perc, F_d_perc, jnd k, jnd b, jnd m, the crossings omega_r and omega_i, the changeovers omega_env and
    omega_perc, and the sensitivities d omega_r/d NAME and d omega_i/d NAME of a crossing to a parameter.

    \b
    Examples:
      haptisym derive fu2019
      haptisym derive fu2019 --keep omega_n --of "Re dH" --to latex
      haptisym derive fu2019 --to c > distortion.c
    """
    from haptisym.verbs.derive.derivation import derive as derive_scene

    if keep and mode:
        raise SceneError(f"--keep says which parameters stay symbols, and so does --{mode}: leave out one of them")
    if as_json and language != "json" and given(click.get_current_context(), "--to"):
        raise SceneError(
            f"--json is one document of all formulas, and --to {language} another output: leave out one of them"
        )
    if names and language in (*_CODE, "sympy"):
        raise SceneError(
            f"--of chooses among formulas, and --to {language} writes all quantities: leave out one of them"
        )
    kept = keep or (() if mode == "numeric" else None)
    d = replace(derive_scene(scene, kept), of=names)
    keep_pages(d.document, d.to_json)
    if as_json or language == "json":
        say_document(d.to_json())
    elif language == "text":
        say(d.document())
    else:
        write(_written(d, language, kept))


def _written(d: Derivation, language: str, kept: tuple[str, ...] | None) -> str:
    """In another language; ``kept`` : the parameters that stay arguments of code."""
    if language in _CODE:
        from haptisym.writing.code.entry import scene_code
        from haptisym.writing.code.languages import Language

        return scene_code(d.scene, Language["NUMPY" if language == "python" else language.upper()], parameters=kept)
    if language == "latex":
        return d.to_latex()
    if language == "sympy":
        from haptisym.pages.script import script

        return script(d)
    from haptisym.writing.html import fragment

    return fragment(d.document()) + "\n"
