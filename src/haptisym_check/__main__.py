"""``python -m haptisym_check FILE SCENE.toml``: status 0 and the claim if the certificate proves
it, 1 and what fails if not.

Status 2, and a sentence on standard error, where there is nothing to check: a file is missing, or
is no JSON.
"""

import os
import sys
from pathlib import Path

from haptisym_check import RefusedError, UnreadableError, check


def main(arguments: list[str]) -> int:
    """The exit status."""
    try:
        if len(arguments) != 2:
            raise UnreadableError("two files are needed: python -m haptisym_check FILE SCENE.toml")
        said, status = check(*map(contents, arguments)), 0
    except UnreadableError as error:
        print(error, file=sys.stderr)
        return 2
    except RefusedError as error:
        said, status = f"NOT proven: {error}", 1
    try:
        print(
            said.encode("ascii", "backslashreplace").decode(), flush=True
        )  # whatever the terminal knows
    except BrokenPipeError:  # whoever read has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return status


def contents(name: str) -> bytes:
    try:
        with Path(name).open("rb") as file:
            return file.read(4_000_001)  # what is longer is refused: a device has no end
    except (OSError, ValueError) as error:
        raise UnreadableError(
            f"{name} cannot be read: {getattr(error, 'strerror', None) or error}"
        ) from None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
