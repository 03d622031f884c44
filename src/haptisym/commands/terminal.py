"""How the command line meets its terminal: the width of pages, characters that an encoding lacks, a
bar of progress, a reader that leaves, Ctrl-C.

Text for terminals and files that lack characters is spelt in words or ASCII signs. Standard output
has the answer alone; everything else goes to standard error, and may be lost there without harm.
"""

from __future__ import annotations

import _thread
import codecs
import os
import re
import shutil
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from io import TextIOWrapper
from pathlib import Path
from textwrap import fill
from time import monotonic
from typing import TYPE_CHECKING, Self
from unicodedata import combining, name, normalize

import click

from haptisym.kernel.budget import Budget, spent
from haptisym.kernel.errors import HaptisymError
from haptisym.writing.characters import MISSING, is_hidden, printable

if TYPE_CHECKING:
    from rich.progress import Progress

    from haptisym.writing.document import Document


PATIENCE = 0.5  # s; what is done sooner shows no bar


@contextmanager
def progress(
    unit: str = "", *, kept: Callable[[str], str] = lambda _: "there is no answer"
) -> Iterator[ProgressBar]:
    """A bar on standard error, where that is a terminal: it comes after half a second and leaves
    nothing behind.

    ``unit`` : of what is counted, as in "1,200 of 65,536 sets"; percent are shown without it.

    ``kept`` : what there is after Ctrl-C, as the end of a sentence that says how far it came; of
    how far that was.

    What it yields is called with what is done, of how much (None: nobody knows, the bar then shows
    only that it lives) and, if there is something to say, at what it is; as often as one likes. It
    does nothing where nobody looks, and raises nothing but a Ctrl-C that was pressed before and
    that a package dropped.

    >>> with progress("sets") as told:
    ...     told(1, 10)
    ...     told(2, None, "the second half")
    """
    context = click.get_current_context(silent=True)
    with ProgressBar(unit) as bar:
        if context is not None:
            context.meta[_BAR] = bar
        try:
            yield bar
        except KeyboardInterrupt:
            far = f" at {bar.reached}" if bar.reached else ""
            raise KeyboardInterrupt(f"{far}: {kept(bar.reached)}") from None


_BAR = "haptisym.progress"  # under which a call of the command line keeps its bar
# What ``interrupts`` yields, and what Ctrl-C calls, if anything.
_pressed: ContextVar[Sequence[int]] = ContextVar("haptisym.pressed", default=())
_stop: ContextVar[Callable[[], None] | None] = ContextVar("haptisym.stop", default=None)


def quiet() -> None:
    """Take the bar away for good, as something is about to be printed."""
    context = click.get_current_context(silent=True)
    bar = context.meta.pop(_BAR, None) if context is not None else None
    if bar is not None:
        bar.stop()


class ProgressBar:
    """What ``progress`` yields: called with what is done, it shows a bar where someone looks."""

    def __init__(self, unit: str) -> None:
        self.unit, self.began = unit, monotonic()
        self.seen = bool(sys.stderr and sys.stderr.isatty())
        self.bar: Progress | None = None
        self.reached = ""
        """How far it came, in words."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Take the bar away; it does not come again."""
        self.seen = False
        if self.bar is not None:
            self.bar.stop()

    def __call__(self, done: float, total: float | None = None, what: str = "") -> None:
        # A Ctrl-C was pressed and the work goes on: something between caught what it raised, as a
        # package being imported may. So it is raised again here.
        if _pressed.get() and _stop.get() is None:
            raise KeyboardInterrupt
        self.reached = self._count(done, total)
        if not self.seen or monotonic() - self.began < PATIENCE:
            return
        # A bar that would appear full shows nothing.
        if self.bar is None and done == total:
            return
        if self.bar is None:
            self.bar = _bar()
            self.bar.add_task(what, count="")
            self.bar.start()
        self.bar.update(
            self.bar.task_ids[0],
            description=what,
            count=", ".join(filter(None, (self.reached, _limit()))),
        )
        self.bar.tasks[0].total = total  # ``update`` takes None for "as before"
        self.bar.update(self.bar.task_ids[0], completed=done)

    def _count(self, done: float, total: float | None) -> str:
        """What is done, in words: of how much, or in percent; "" where neither is known."""
        if total is None:
            return f"{_figure(done)} {self.unit}" if self.unit else ""
        if self.unit:
            return f"{_figure(done)} of {_figure(total)} {self.unit}"
        return f"{100 * done / total if total else 100:.0f} %"


def _figure(x: float) -> str:
    """A count or a time in three digits; whole and with separators from a thousand on."""
    return f"{x:,.0f}" if x >= 999.5 else f"{x:.3g}"


def _limit() -> str:
    """How much of the limit is used; the clock beside it goes on while other programs have the
    processor."""
    used = spent()
    return "" if used is None else f"processor {used[0]:.0f} of {used[1]:g} s"


def _bar() -> Progress:
    """The bar of Rich, which is loaded only where one is shown."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.table import Column

    console = Console(stderr=True)
    roomy = console.width >= 60
    count, what = (
        TextColumn(x, markup=False, table_column=Column(no_wrap=True, overflow="crop"))
        for x in ("{task.fields[count]}", "{task.description}")
    )
    times = (TimeElapsedColumn(), TimeRemainingColumn()) if roomy else ()
    # Pages ask standard output for its encoding while the bar is there: Rich must not stand in
    # front of it.
    return Progress(
        BarColumn(30 if roomy else 8),
        count,
        *times,
        what,
        console=console,
        transient=True,
        redirect_stdout=False,
    )


_SIGNS = {
    "−": "-",
    "–": "-",
    "—": "-",
    "─": "-",
    "━": "-",
    "═": "=",
    "│": "|",
    "·": "*",
    "⋅": "*",
    "×": "*",
    "∙": "*",
    "÷": "/",
    "⁄": "/",
    "≈": "~=",
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "≡": "==",
    "±": "+-",
    "∓": "-+",
    "∞": "inf",
    "√": "sqrt",
    "∂": "d",
    "∑": "sum",
    "∏": "product",
    "∫": "integral",
    "∈": "in",
    "∠": "angle",
    "→": "->",
    "←": "<-",
    "↔": "<->",
    "⇒": "=>",
    "°": "deg",
    "µ": "u",
    "‘": "'",
    "’": "'",
    "‚": "'",
    "“": '"',
    "”": '"',
    "„": '"',
    "′": "'",
    "″": "''",
    "…": "...",
    "•": "*",
    "†": "+",
    "ß": "ss",
    "æ": "ae",
    "Æ": "AE",
    "œ": "oe",
    "Œ": "OE",
    "ø": "o",
    "Ø": "O",
    "ł": "l",
    "Ł": "L",
    "đ": "d",
    "ð": "d",
    "þ": "th",
    "ı": "i",
    "ȷ": "j",
    "€": "EUR",
    "£": "GBP",
    "§": "section ",
    "©": "(c)",
    "®": "(R)",
    "«": '"',
    "»": '"',
    "∆": "Delta",
    "Ω": "Omega",
    "ϵ": "epsilon",
    "ϕ": "phi",
    "ς": "sigma",
    "ϑ": "theta",
    "\N{NO-BREAK SPACE}": " ",
    "\N{NARROW NO-BREAK SPACE}": " ",
    MISSING: "?",
}
_GREEK = re.compile(r"GREEK (SMALL|CAPITAL) LETTER (\w+)")
_ALIASES = {"LAMDA": "lambda"}


def spelt(text: str, encoding: str) -> str:
    """The text with words or ASCII signs for the characters that an encoding lacks.

    >>> spelt("ω² ≈ 40 °", "ascii"), spelt("ω² ≈ 40 °", "latin-1")
    ('omega^2 ~= 40 deg', 'omega² ~= 40 °')
    """
    # Most texts can be encoded as they are; only the others are taken apart.
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return "".join(x if _held(x, encoding) else _word(text, i) for i, x in enumerate(text))
    except LookupError:
        return text
    return text


def _held(character: str, encoding: str) -> bool:
    """Whether an encoding has a character."""
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
        # 2ω would become 2omega, which reads as one word.
        apart = " " if at and text[at - 1].isalnum() else ""
        return apart + (word.capitalize() if kind == "CAPITAL" else word)
    is_raised = "SUPERSCRIPT" in name(x, "")
    is_lowered = "SUBSCRIPT" in name(x, "")
    letters = [y for y in normalize("NFKD", x) if not combining(y)]
    # A small sign decomposes to a sign that ASCII may lack in turn, as a raised minus does.
    if is_raised or is_lowered:
        letters = [_SIGNS.get(y, y) for y in letters]
    plain = "".join(letters)
    if plain.isascii() and plain:
        # One ^ before several raised digits: 10^12.
        follows = at and "SUPERSCRIPT" in name(text[at - 1], "")
        if is_raised and not follows:
            return f"^{plain}"
        return f"_{plain}" if is_lowered else plain
    if combining(x):
        return ""
    return f"\\u{ord(x):04x}" if ord(x) < 0x10000 else f"\\U{ord(x):08x}"


def escaped(document: str, encoding: str) -> str:
    r"""A JSON document with JSON's own escapes for the characters that an encoding lacks, and for
    hidden ones.

    >>> escaped('{"title": "Prüfstand ω"}', "latin-1")
    '{"title": "Prüfstand \\u03c9"}'
    """

    def escape(x: str) -> str:
        if _held(x, encoding) and not is_hidden(x):
            return x
        # JSON's escapes are units of UTF-16: two for a character beyond 16 bits.
        units = x.encode("utf-16-be", "surrogatepass")
        return "".join(f"\\u{units[i] << 8 | units[i + 1]:04x}" for i in range(0, len(units), 2))

    try:
        return document.translate({ord(x): escape(x) for x in set(document)})
    except LookupError:
        return document


def _spell(error: UnicodeError) -> tuple[str, int]:
    """Python's handler for characters that an encoding lacks: the words for them, and where to go
    on."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_word(error.object, i) for i in range(error.start, error.end)), error.end


_MOMENT = 0.02  # s, until a Ctrl-C comes again that fell where errors are dropped


class ReaderLeft(Exception):  # noqa: N818  it is nobody's error
    """Whoever read standard output has closed it, as ``head`` does."""


class CannotWriteError(HaptisymError):
    """A file or standard output does not take what is written."""


def prepare() -> None:
    """Let both streams spell what their encoding lacks; ASCII in a terminal whose locale was set to
    C or POSIX."""
    # With a handler of errors no text can fail to be printed, whatever a scene is called.
    codecs.register_error("haptisym.spelt", _spell)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(
                encoding="ascii" if _is_plain(stream) else stream.encoding, errors="haptisym.spelt"
            )


def _is_plain(stream: TextIOWrapper) -> bool:
    """Python writes UTF-8 where the locale is C, as containers have it unasked; a terminal that was
    told so has ASCII."""
    if not stream.isatty() or os.environ.get("PYTHONIOENCODING") or os.environ.get("PYTHONUTF8"):
        return False
    locale = next((x for name in ("LC_ALL", "LC_CTYPE", "LANG") if (x := os.environ.get(name))), "")
    return locale in ("C", "POSIX")


PAGE, WIDEST, _ROOM = 80, 96, 22  # columns, as ``haptisym.writing.plain``, which only a page needs


def _columns() -> int:
    """As wide as the terminal; 80 anywhere else, so that pages can be compared."""
    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    return min(shutil.get_terminal_size((PAGE, 24)).columns, WIDEST) if is_terminal else PAGE


def say_list(title: str, rows: Sequence[tuple[str, str]]) -> None:
    """Names and what they are, on standard output: a page for which neither its writer nor SymPy is
    loaded."""
    columns, after = _columns(), 4 + max(len(key) for key, _ in rows)
    lines, is_wide = [fill(title, columns), ""], columns - after >= _ROOM
    # Where little room is left beside the names, what they are stands below them.
    for key, words in rows:
        begun = f"  {key}".ljust(after) if is_wide else " " * 4
        lines += [] if is_wide else [f"  {key}"]
        rest = " " * len(begun)
        lines.append(
            fill(
                words, columns, initial_indent=begun, subsequent_indent=rest, break_on_hyphens=False
            )
        )
    write(spelt("\n".join(lines) + "\n", _encoding()))


def say(page: Document, digits: int | None = None, *, formulas: bool = False) -> None:
    """A page on standard output: as wide as the terminal, 80 columns anywhere else so that it can
    be compared."""
    from haptisym.writing.document import DIGITS  # only a page needs the writer
    from haptisym.writing.plain import plain

    write(
        plain(
            page,
            _columns(),
            lambda words: spelt(words, _encoding()),
            digits=digits or DIGITS,
            formulas=formulas,
        )
    )


def say_document(document: str) -> None:
    """A JSON document on standard output."""
    write(escaped(document, _encoding()) + "\n")


def write(text: str) -> None:
    """Text on standard output as it is. ReaderLeft or CannotWriteError where it does not get
    there."""
    # Python has None where the descriptor was closed by whoever started the process.
    if sys.stdout is None:
        raise CannotWriteError("standard output cannot be written: it is closed")
    # The bar is redrawn in place: a page between two of its lines would be torn.
    quiet()
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        _close()
        raise ReaderLeft from None
    except OSError as error:
        _close()
        raise CannotWriteError(f"standard output cannot be written: {_reason(error)}") from None


def says_help(option: click.Option | None) -> click.Option | None:
    """The option ``--help``, which says so where standard output does not take what it prints."""
    if option is not None:
        option.callback = _say_help
    return option


def _say_help(context: click.Context, _option: click.Parameter, asked: bool) -> None:
    """Print the help by ``write``, whose errors are sentences."""
    if asked and not context.resilient_parsing:
        write(f"{context.get_help()}\n")
        context.exit()


def note(message: str) -> None:
    """A message on standard error; lost where that is closed or full."""
    _tell(printable(message))


def _tell(message: str) -> None:
    """A message on standard error as it is, in the terminal's width."""
    quiet()
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
    if line.startswith("    "):
        return line
    return fill(line, width, break_long_words=False, break_on_hyphens=False)


def _encoding() -> str:
    """The encoding of standard output; UTF-8 where it has none."""
    return getattr(sys.stdout, "encoding", None) or "utf-8"


@contextmanager
def to_file(what: str, path: Path) -> Iterator[None]:
    """Turn an OSError inside into CannotWriteError, a sentence that names the file."""
    try:
        yield
    except OSError as error:
        raise CannotWriteError(f"{what}: {path} cannot be written: {_reason(error)}") from None


def _reason(error: OSError) -> str:
    """What the system says of an error, in small letters as within a sentence."""
    return (error.strerror or str(error)).lower()


def _close() -> None:
    """Send what is still in the buffer of standard output nowhere, so that the end of the process
    does not try to write it again."""
    with suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _interrupt() -> None:
    """Ctrl-C to the main thread, which may wait for others."""
    # A signal to that very thread ends its waiting in a system call; Windows has none.
    if sys.platform == "win32":
        _thread.interrupt_main()
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


@contextmanager
def loading() -> Iterator[None]:
    """Ctrl-C ends the process at once: packages that are being loaded have handlers that would drop
    what it raises."""
    before = signal.getsignal(signal.SIGINT)
    # Only the main thread may set handlers; where Ctrl-C is ignored it stays so.
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    signal.signal(signal.SIGINT, lambda *_: os._exit(130))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def interrupts() -> Iterator[list[int]]:
    """Ctrl-C raises KeyboardInterrupt, once; what it yields then is not empty, even if an import
    made another error of it.

    Inside of ``ends_with_what_is_proven`` it stops the work instead, which then answers.
    Whoever presses it again while things are being tidied up does not wait any longer: status 130
    at once. Where it falls into code whose errors Python drops (a finalizer, a callback of an
    import's lock) it comes again a moment later; where a package caught it, with the next report of
    progress.
    """
    seen: list[int] = []
    dropped = sys.unraisablehook
    is_ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )

    def interrupted(number: int, _frame: object) -> None:
        """The first Ctrl-C stops the work; a second one ends the process without tidying up."""
        if seen:
            if sys.stderr and sys.stderr.isatty():
                _tell("\x1b[?25h")  # a bar of progress hides the cursor
            os._exit(130)
        seen.append(number)
        if (stop := _stop.get()) is None:
            raise KeyboardInterrupt
        stop()

    def again(lost: sys.UnraisableHookArgs) -> None:
        """A KeyboardInterrupt that Python could not raise comes again a moment later."""
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            dropped(lost)
            return
        # As if it had not been pressed: else the repeated signal would count as the second one.
        seen.clear()
        later = threading.Timer(_MOMENT, _interrupt)
        # A thread that is no daemon would keep the process alive.
        later.daemon = True
        later.start()

    # Only the main thread may set handlers, and one that somebody else has set stays.
    if is_ours:
        signal.signal(signal.SIGINT, interrupted)
        sys.unraisablehook = again
        token = _pressed.set(seen)
    try:
        yield seen
    finally:
        if is_ours:
            _pressed.reset(token)
            sys.unraisablehook = dropped
            signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def ends_with_what_is_proven(budget: Budget) -> Iterator[None]:
    """The first Ctrl-C inside lets the work end with what is proven by then; a second one ends the
    process."""
    token = _stop.set(budget.stop)
    try:
        yield
    finally:
        _stop.reset(token)
