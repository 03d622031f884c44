"""What the verbs of the command line share: scenes, options, limits, progress, terminals.

The bar of progress of every verb that may take long.

Text for terminals and files that lack characters: what an encoding does not hold is spelt in words or ASCII signs.

How the command line meets its terminal: pages as wide, characters that it has, nobody who reads, Ctrl-C.

A verb of the command line: what holds for the options of all of them.

What the verbs of the command line share: the scene that they are about, options alike, and how an answer is handed over.

The option ``--limit SECONDS``: verbs that may take long show a bar, and say in time what is proven so far.
"""

from __future__ import annotations

import _thread
import codecs
import inspect
import os
import re
import shutil
import signal
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from contextlib import contextmanager, suppress
from functools import wraps
from io import TextIOWrapper
from pathlib import Path
from textwrap import fill
from time import monotonic
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from unicodedata import combining, name, normalize

import click
from click.core import ParameterSource

from haptisym.figures.pen import checked, checked_report
from haptisym.judge.answers import Answer
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.errors import HaptisymError, NothingToDrawError, SceneError
from haptisym.model.scenefile import load_scene

if TYPE_CHECKING:
    from rich.progress import Progress

    from haptisym.writing.document import Document


PATIENCE = 0.5  # s; what is done sooner shows no bar


@contextmanager
def progress(unit: str = "", *, kept: str = "there is no answer") -> Iterator[ProgressBar]:
    """A bar on standard error, where that is a terminal: it comes after half a second and leaves nothing behind.

    ``unit`` : of what is counted, as in "1,200 of 65,536 sets"; percent are shown without it.

    ``kept`` : what there is after Ctrl-C, as the end of a sentence that says how far it came.

    What it yields is called with what is done, of how much (None: nobody knows, the bar then shows only that it lives) and, if
    there is something to say, at what it is; as often as one likes. It never raises, and does nothing where nobody looks.

    >>> with progress("sets") as told:
    ...     told(1, 10)
    ...     told(2, None, "the second half")
    """
    context = click.get_current_context(silent=True)
    with ProgressBar(unit) as told:
        if context is not None:
            context.meta[_BAR] = told
        try:
            yield told
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f" at {told.reached}: {kept}" if told.reached else f": {kept}") from None


_BAR = "haptisym.progress"  # under which a call of the command line keeps its bar


def quiet() -> None:
    """Take the bar away for good, as something is about to be printed."""
    context = click.get_current_context(silent=True)
    told = context.meta.pop(_BAR, None) if context is not None else None
    if told is not None:
        told.stop()


class ProgressBar:
    """What ``progress`` yields."""

    def __init__(self, unit: str) -> None:
        self.unit, self.began = unit, monotonic()
        self.seen = bool(sys.stderr and sys.stderr.isatty())
        self.bar: Progress | None = None
        self.reached = ""
        """How far it came, in words."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _what: BaseException | None, _at: TracebackType | None
    ) -> None:
        self.stop()

    def stop(self) -> None:
        """The bar leaves, and does not come again."""
        self.seen = False
        if self.bar is not None:
            self.bar.stop()

    def __call__(self, done: float, total: float | None = None, what: str = "") -> None:
        self.reached = self._count(done, total)
        if not self.seen or monotonic() - self.began < PATIENCE or (self.bar is None and done == total):
            return
        if self.bar is None:
            self.bar = _bar()
            self.bar.add_task(what, count="")
            self.bar.start()
        self.bar.update(self.bar.task_ids[0], description=what, count=self.reached)
        self.bar.tasks[0].total = total  # ``update`` takes None for "as before"
        self.bar.update(self.bar.task_ids[0], completed=done)

    def _count(self, done: float, total: float | None) -> str:
        if total is None:
            return f"{_figure(done)} {self.unit}" if self.unit else ""
        if self.unit:
            return f"{_figure(done)} of {_figure(total)} {self.unit}"
        return f"{100 * done / total if total else 100:.0f} %"


def _figure(x: float) -> str:
    return f"{x:,.0f}" if x >= 999.5 else f"{x:.3g}"


def _bar() -> Progress:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.table import Column

    console = Console(stderr=True)
    roomy = console.width >= 60
    count, what = (
        TextColumn(x, markup=False, table_column=Column(no_wrap=True, overflow="crop"))
        for x in ("{task.fields[count]}", "{task.description}")
    )
    times = (TimeElapsedColumn(), TimeRemainingColumn()) if roomy else ()
    return Progress(BarColumn(30 if roomy else 8), count, *times, what, console=console, transient=True)


_SIGNS = {
    "−": "-", "–": "-", "—": "-", "─": "-", "━": "-", "═": "=", "│": "|", "·": "*", "⋅": "*", "×": "*", "∙": "*",
    "÷": "/", "⁄": "/", "≈": "~=", "≤": "<=", "≥": ">=", "≠": "!=", "≡": "==", "±": "+-", "∓": "-+", "∞": "inf",
    "√": "sqrt", "∂": "d", "∑": "sum", "∏": "product", "∫": "integral", "∈": "in", "∠": "angle", "→": "->",
    "←": "<-", "↔": "<->", "⇒": "=>", "°": "deg", "µ": "u", "‘": "'", "’": "'", "‚": "'", "“": '"', "”": '"',
    "„": '"', "′": "'", "″": "''", "…": "...", "•": "*", "†": "+", "ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe",
    "Œ": "OE", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L", "đ": "d", "ð": "d", "þ": "th", "ı": "i", "ȷ": "j", "€": "EUR",
    "£": "GBP", "§": "section ", "©": "(c)", "®": "(R)", "«": '"', "»": '"', "∆": "Delta", "Ω": "Omega",
    "ϵ": "epsilon", "ϕ": "phi", "ς": "sigma", "ϑ": "theta", "\N{NO-BREAK SPACE}": " ",
    "\N{NARROW NO-BREAK SPACE}": " ",
}  # fmt: skip
_GREEK = re.compile(r"GREEK (SMALL|CAPITAL) LETTER (\w+)")
_ALIASES = {"LAMDA": "lambda"}


def spelt(text: str, encoding: str) -> str:
    """The text with words or ASCII signs for the characters that an encoding lacks.

    >>> spelt("ω² ≈ 40 °", "ascii"), spelt("ω² ≈ 40 °", "latin-1")
    ('omega^2 ~= 40 deg', 'omega² ~= 40 °')
    """
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return "".join(x if _held(x, encoding) else _word(text, i) for i, x in enumerate(text))
    except LookupError:
        return text
    return text


def _held(character: str, encoding: str) -> bool:
    try:
        character.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True


def _word(text: str, at: int) -> str:
    """The ASCII for one character of a text."""
    x = text[at]
    if x in _SIGNS:
        return _SIGNS[x]
    if greek := _GREEK.match(name(x, "")):
        kind, letter = greek.groups()
        word = _ALIASES.get(letter, letter.lower())
        apart = " " if at and text[at - 1].isalnum() else ""
        return apart + (word.capitalize() if kind == "CAPITAL" else word)
    is_small = any(word in name(x, "") for word in ("SUPERSCRIPT", "SUBSCRIPT"))
    plain = "".join(_SIGNS.get(y, y) if is_small else y for y in normalize("NFKD", x) if not combining(y))
    if plain.isascii() and plain:
        raised = "SUPERSCRIPT" in name(x, "") and not (at and "SUPERSCRIPT" in name(text[at - 1], ""))
        return f"^{plain}" if raised else f"_{plain}" if "SUBSCRIPT" in name(x, "") else plain
    return "" if combining(x) else f"\\u{ord(x):04x}" if ord(x) < 0x10000 else f"\\U{ord(x):08x}"


def escaped(document: str, encoding: str) -> str:
    r"""A JSON document with JSON's own escapes for the characters that an encoding lacks.

    >>> escaped('{"title": "Prüfstand ω"}', "latin-1")
    '{"title": "Prüfstand \\u03c9"}'
    """

    def escape(x: str) -> str:
        if _held(x, encoding):
            return x
        units = x.encode("utf-16-be", "surrogatepass")
        return "".join(f"\\u{units[i] << 8 | units[i + 1]:04x}" for i in range(0, len(units), 2))

    try:
        document.encode(encoding)
    except UnicodeEncodeError:
        return "".join(map(escape, document))
    except LookupError:
        return document
    return document


def _spell(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_word(error.object, i) for i in range(error.start, error.end)), error.end


HANDLER = "haptisym.spelt"
"""Name of the error handler of codecs that spells what is lacking, once ``register`` was called."""


def register() -> None:
    """Make the handler known by its name; once is enough."""
    codecs.register_error(HANDLER, _spell)


_MOMENT = 0.02  # s


class ReaderLeft(Exception):  # noqa: N818  it is nobody's error
    """Whoever read standard output has closed it, as ``head`` does."""


class CannotWriteError(HaptisymError):
    """A file or standard output does not take what is written."""


def prepare() -> None:
    """Let both streams spell what their encoding lacks; ASCII in a terminal whose locale was set to C or POSIX."""
    register()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(encoding="ascii" if _is_plain(stream) else stream.encoding, errors=HANDLER)


def _is_plain(stream: TextIOWrapper) -> bool:
    """Python writes UTF-8 where the locale is C, as containers have it unasked; a terminal that was told so has ASCII."""
    if not stream.isatty() or os.environ.get("PYTHONIOENCODING") or os.environ.get("PYTHONUTF8"):
        return False
    locale = next((x for name in ("LC_ALL", "LC_CTYPE", "LANG") if (x := os.environ.get(name))), "")
    return locale in ("C", "POSIX")


def say(page: Document) -> None:
    """A page on standard output: as wide as the terminal, 80 columns anywhere else so that it can be compared."""
    from haptisym.writing.plain import PAGE, WIDEST, plain  # only a page needs the writer

    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    columns = min(shutil.get_terminal_size((PAGE, 24)).columns, WIDEST) if is_terminal else PAGE
    context = click.get_current_context(silent=True)
    style = context.meta.get(STYLE, {}) if context is not None else {}
    write(plain(page, columns, _spell_in_streams, **style))


def say_document(document: str) -> None:
    """A JSON document on standard output."""
    write(escaped(document, _encoding()) + "\n")


def write(text: str) -> None:
    """Text on standard output as it is. ReaderLeft or CannotWriteError where it does not get there."""
    if sys.stdout is None:
        raise CannotWriteError("standard output cannot be written: it is closed")
    with to_standard_output():
        sys.stdout.write(text)
        sys.stdout.flush()


def note(message: str) -> None:
    """A message on standard error; lost where that is closed or full."""
    if sys.stderr is None:
        return
    with suppress(OSError, ValueError):
        if sys.stderr.isatty():
            message = "\n".join(map(_narrowed, message.split("\n")))
        sys.stderr.write(f"{message}\n")
        sys.stderr.flush()


def _narrowed(line: str) -> str:
    """A line of a message in the terminal's width; what is indented is typed, and stays."""
    width = min(max(os.get_terminal_size(sys.stderr.fileno()).columns, 40), 96)
    return line if line.startswith("    ") else fill(line, width, break_long_words=False, break_on_hyphens=False)


def _spell_in_streams(words: str) -> str:
    return spelt(words, _encoding())


def _encoding() -> str:
    return getattr(sys.stdout, "encoding", None) or "utf-8"


@contextmanager
def to_standard_output() -> Iterator[None]:
    """What goes wrong inside with standard output, by name; nothing more is then tried to be written there."""
    try:
        yield
    except BrokenPipeError:
        _close()
        raise ReaderLeft from None
    except OSError as error:
        if error.filename is not None:
            raise
        _close()
        raise CannotWriteError(f"standard output cannot be written: {_reason(error)}") from None


@contextmanager
def to_file(what: str, path: Path) -> Iterator[None]:
    """What goes wrong inside with writing a file, as a sentence that names it."""
    try:
        yield
    except OSError as error:
        raise CannotWriteError(f"{what}: {path} cannot be written: {_reason(error)}") from None


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _close() -> None:
    """What is still in the buffer goes nowhere, so that the end of the process does not try again."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _interrupt() -> None:
    """Ctrl-C to the main thread, which may wait for others."""
    if sys.platform == "win32":
        _thread.interrupt_main()
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


@contextmanager
def interrupts() -> Iterator[list[int]]:
    """Ctrl-C raises KeyboardInterrupt, once; what it yields then is not empty, even if an import made another error of it.

    Whoever presses it again while things are being tidied up does not wait any longer: status 130 at once. Where it falls into
    code whose errors Python drops (a finalizer, a callback of an import's lock) it comes again a moment later.
    """
    seen: list[int] = []
    dropped = sys.unraisablehook
    is_ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )

    def interrupted(number: int, _frame: object) -> None:
        if seen:
            note("\x1b[?25h" if sys.stderr and sys.stderr.isatty() else "")  # a bar of progress hides the cursor
            os._exit(130)
        seen.append(number)
        raise KeyboardInterrupt

    def again(lost: sys.UnraisableHookArgs) -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            dropped(lost)
            return
        seen.clear()
        later = threading.Timer(_MOMENT, _interrupt)
        later.daemon = True
        later.start()

    if is_ours:
        signal.signal(signal.SIGINT, interrupted)
        sys.unraisablehook = again
    try:
        yield seen
    finally:
        if is_ours:
            sys.unraisablehook = dropped
            signal.signal(signal.SIGINT, signal.default_int_handler)


OptionRule = tuple[str, str, str]
"""Two options, and what is to be said of them."""


def verb(
    *, apart: Sequence[OptionRule] = (), needs: Sequence[OptionRule] = (), pages: bool = True, formulas: str = ""
) -> Callable[[Callable[..., Any]], click.Command]:
    """The decorator of a verb, in place of ``click.command()``.

    ``apart`` : options that may not both be given, and why: a sentence to which "leave out one of them" is added. ``needs`` : an
    option that means nothing without another one, and what it is about. ``pages`` : whether it answers with a page, which
    ``--latex`` and ``--report`` write to files. ``formulas`` : the option that
    asks for all that the page has, ``--formulas`` or ``--all``.
    """
    return click.command(cls=Verb, apart=apart, needs=needs, pages=pages, formulas=formulas)


def digits_option() -> click.Option:
    """The option ``--digits N``, of a page (4 if not given) and of a JSON document (15)."""
    words = "Digits to print (4 if not given; 15 in --json)."
    return click.Option(["--digits"], type=click.IntRange(1, 10_000), metavar="N", help=words)


STYLE = "haptisym.style"
"""How a page is printed, in the context's ``meta``: with how many digits, and whether with formulas."""
DIGITS = 4  # as ``haptisym.writing.document``, which only a page needs
PAGES = "haptisym.pages"
"""What ``--latex`` and ``--report`` name, in the context's ``meta``: whoever hands an answer over writes them."""


class Verb(click.Command):
    """A command that refuses what would be ignored or lost.

    Each option is given once, unless it may be repeated; options of ``apart`` are not given together, those of ``needs`` only
    together; no output is written over a file that the call reads, or over another output. All that is found before the work
    begins.
    """

    def __init__(
        self,
        *args: Any,
        apart: Sequence[OptionRule] = (),
        needs: Sequence[OptionRule] = (),
        pages: bool = True,
        formulas: str = "",
        **options: Any,
    ) -> None:
        super().__init__(*args, **options)
        self.apart, self.needs = apart, needs
        if pages:
            self.params += [
                _file("latex", "Write the page as a LaTeX document."),
                _file("report", "Write the page as a report (.html or .pdf).", checked_report),
            ]
            own = {x.name for x in self.params}
            self.params += [] if "digits" in own else [digits_option()]
            words = {
                "--formulas": "Print the formulas, too.",
                "--all": "Print every measure with its formulas and values.",
            }
            self.params += (
                [click.Option([formulas, "formulas"], is_flag=True, help=words[formulas])] if formulas else []
            )

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click; an option that is given twice is refused."""
        if not ctx.resilient_parsing:
            _once_each(self.make_parser(ctx).parse_args(args=list(args))[2])
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """As click; what contradicts itself, is ignored or would be lost is refused before."""
        for one, other, why in self.apart:
            if given(ctx, one) and given(ctx, other):
                raise SceneError(f"{why}: leave out one of them")
        for one, other, about in self.needs:
            if given(ctx, one) and not given(ctx, other):
                raise SceneError(f"{one} is about {about}: it needs {other}, or leave it out")
        _nothing_lost(ctx)
        ctx.meta[PAGES] = {name: ctx.params.pop(name, None) for name in ("latex", "report")}
        ctx.meta[STYLE] = {"digits": ctx.params.get("digits") or DIGITS, "formulas": ctx.params.pop("formulas", False)}
        if "digits" not in inspect.signature(self.callback or (lambda: None)).parameters:
            ctx.params.pop("digits", None)
        return super().invoke(ctx)


def _file(name: str, words: str, checked: Callable[[Path], Path] = Path) -> click.Option:
    def writable(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
        return None if path is None else can_be_written(name, checked(path))

    kind = click.Path(dir_okay=False, path_type=Path)
    return click.Option([f"--{name}"], type=kind, metavar="FILE", callback=writable, help=words)


def can_be_written(what: str, path: Path) -> Path:
    """The path; SceneError where nothing can be written there, before the work begins."""
    if not path.parent.is_dir():
        raise SceneError(f"{what}: {path} cannot be written: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise SceneError(f"{what}: {path} cannot be written: permission denied")
    return path


def given(ctx: click.Context, option: str) -> bool:
    """Whether an option such as ``--digits`` stands on the command line."""
    return any(
        option in (*x.opts, x.name) and ctx.get_parameter_source(str(x.name)) is ParameterSource.COMMANDLINE
        for x in ctx.command.params
    )


def _once_each(order: Sequence[click.Parameter]) -> None:
    """Refuse an option that is given twice, and two flags of which only the last would count."""
    options = [x for x in order if isinstance(x, click.Option) and not x.multiple]
    for key in dict.fromkeys(x.name for x in options):
        same = list(dict.fromkeys(x.opts[-1] for x in options if x.name == key))
        if len(same) > 1:
            raise SceneError(f"{same[0]} and {same[1]} contradict each other: leave out one of them")
    for option, times in Counter(options).items():
        if times > 1 and not option.is_flag:
            raise SceneError(
                f"{option.opts[-1]} is given {times} times, and only one of them would count: leave out the others"
            )


def _nothing_lost(ctx: click.Context) -> None:
    """Refuse an output that would be written over a file that is read, whatever its name, or over another output."""
    outputs = [
        (x.opts[-1], ctx.params[str(x.name)])
        for x in ctx.command.params
        if isinstance(ctx.params.get(str(x.name)), Path)
    ]
    inputs = [path for x in ctx.command.params for path in _files(ctx.params.get(str(x.name)))]
    for i, (option, path) in enumerate(outputs):
        for read in inputs:
            if _is_same(path, read):
                raise SceneError(
                    f"{option}: {path} is read by this very call, and would be overwritten: choose another name"
                )
        for other, taken in outputs[:i]:
            if path == taken or _is_same(path, taken):
                raise SceneError(
                    f"{other} and {option} would both be written to {path}: choose another name for one of them"
                )


def not_over(read: Iterable[Path | None], outputs: Mapping[str, Path | None]) -> None:
    """SceneError where an output would be written over a file that a scene names."""
    for path in filter(None, read):
        for option, target in outputs.items():
            if target is not None and _is_same(target, path):
                raise SceneError(
                    f"--{option}: {target} is read by this very call, and would be overwritten: choose another name"
                )


def _files(value: Any) -> Iterator[Path]:
    """The files that a text of the command line names, if it names any."""
    if isinstance(value, tuple):
        for one in value:
            yield from _files(one)
    elif isinstance(value, str) and "\0" not in value:
        yield Path(value)


def _is_same(one: Path, other: Path) -> bool:
    try:
        return one.is_file() and other.is_file() and one.samefile(other)
    except OSError:  # a name too long to be one
        return False


Command = Callable[..., Any]


def scene_argument(command: Command) -> Command:
    """SCENE and, of a scene with several environments, ``--environment NAME``: the command gets the loaded scene."""

    @click.argument("scene")
    @environment_option
    @wraps(command)
    def loaded(*args: Any, scene: str, environment: str | None, **options: Any) -> Any:
        return command(*args, scene=load_scene(scene, environment), **options)

    return loaded


def environment_option(command: Command) -> Command:
    """The option ``--environment NAME``."""
    return click.option(
        "--environment", "environment", metavar="NAME", help="Use this environment, where a scene has several."
    )(command)


def json_option(command: Command) -> Command:
    """The option ``--json``."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")(command)


def figure_option(what: str) -> Callable[[Command], Command]:
    """The option ``--figure FILE``, for a drawing of what is said; a path that will not do is refused before the work begins."""
    kind = click.Path(dir_okay=False, path_type=Path)
    help_text = f"Draw {what} (.svg, .pdf or .png)."
    return click.option("--figure", type=kind, metavar="FILE", callback=_writable, help=help_text)


def _writable(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
    return None if path is None else checked(can_be_written("figure", path))


def file_option(name: str, help_text: str) -> Callable[[Command], Command]:
    """An option that names a file to be written; a path that will not do is refused before the work begins."""

    def writable(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
        return None if path is None else can_be_written(name, path)

    kind = click.Path(dir_okay=False, path_type=Path)
    return click.option(f"--{name}", type=kind, metavar="FILE", callback=writable, help=help_text)


def figures_option(command: Command) -> Command:
    """The option ``--figures DIR``."""
    kind = click.Path(file_okay=False, path_type=Path)
    return click.option("--figures", type=kind, metavar="DIR", help="Write the figures to this folder.")(command)


def certificate_option(command: Command) -> Command:
    """The option ``--certificate FILE``."""
    return file_option("certificate", "Write a certificate, for python -m haptisym_check FILE SCENE.toml.")(command)


def written(what: str, path: Path) -> None:
    """Tell on standard error that a file is there."""
    quiet()
    note(f"{what} written to {path}")


def keep(what: str, path: Path, save: Callable[[], Any]) -> None:
    """Write a file and tell so on standard error; what it cannot be written for is a sentence that names it."""
    with to_file(what, path):
        save()
    written(what, path)


def keep_figures(folder: Path, save: Callable[[], Sized]) -> None:
    """Write figures to a folder, and tell how many."""
    with to_file("figures", folder):
        count = len(save())
    written(f"{count} figures", folder)


def drawn(found: Answer, path: Path | None) -> None:
    """Write the figure of an answer where one was asked for, and tell so on standard error, or that there is nothing to draw."""
    if path is None:
        return
    try:
        keep("figure", path, lambda: found.save_figure(path))
    except NothingToDrawError as error:
        quiet()
        note(f"no figure: {error}")


def proven(found: Answer, path: Path | None) -> None:
    """Write the certificate of an answer where one was asked for, and tell so on standard error."""
    if path is not None:
        proof = found.certificate()
        keep("certificate", path, lambda: path.write_text(proof, encoding="utf-8"))


def keep_pages(document: Callable[[], Any], record: Callable[[], str]) -> None:
    """Write the page of an answer to the files that ``--latex`` and ``--report`` name; ``record`` : its document of JSON."""
    asked = click.get_current_context().meta[PAGES]
    if (path := asked["latex"]) is not None:
        from haptisym.writing.latex import latex

        keep("LaTeX", path, lambda: path.write_text(latex(document()), encoding="ascii"))
    if (report := asked["report"]) is not None:
        from haptisym.pages.report import save

        keep("report", report, lambda: save(document(), record(), report))


def hand_over(found: Answer, *, as_json: bool) -> None:
    """Print an answer; exit status 3 where something in it stayed undecided."""
    show(found, as_json=as_json)
    end(found)


def show(found: Answer, *, as_json: bool) -> None:
    """Print an answer, as its page or as its document."""
    keep_pages(found.document, found.to_json)
    if as_json:
        quiet()
        say_document(found.to_json())
        return
    told = found.document()
    quiet()
    say(told)


def end(found: Answer) -> None:
    """Exit status 3 where something in an answer stayed undecided."""
    if not found.certified:
        sys.exit(3)


def limit_option(command: Command) -> Command:
    """The option alone, for a verb whose answer says what is proven so far."""
    return click.option(
        "--limit",
        type=click.FloatRange(min=0, min_open=True, max=1e9),
        default=SECONDS,
        show_default=True,
        metavar="SECONDS",
        help="Stop after this time; print what is proven and mark the rest undecided.",
    )(command)


def within_limit(command: Command) -> Command:
    """The option and its work, for a verb whose answer is whole or none: LimitError when the time is over."""

    @limit_option
    @wraps(command)
    def timed(*args: Any, limit: float, **options: Any) -> Any:
        with progress() as told, limited(limit, told):
            return command(*args, **options)

    return timed
