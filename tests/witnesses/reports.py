"""Reports of HTML without their drawings, which take seconds and change no word."""

from __future__ import annotations

from unittest import mock

from haptisym.judge.answers import Answer
from haptisym.pages import report
from haptisym.writing.htmltext import Html


def undrawn(answer: Answer) -> str:
    with mock.patch.object(report, "_drawn", return_value=Html()):
        return report.page(answer)
