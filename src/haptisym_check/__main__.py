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
    """Print the claim, or why it is not proven, and return the exit status."""
    try:
        if len(arguments) != 2:
            raise UnreadableError("two files are needed: python -m haptisym_check FILE SCENE.toml")
        message, status = check(*map(contents, arguments)), 0
    except UnreadableError as error:
        print(error, file=sys.stderr)
        return 2
    except RefusedError as error:
        message, status = f"NOT proven: {error}", 1
    try:
        # In ASCII: names of a scene may have letters that the terminal's encoding has not.
        print(message.encode("ascii", "backslashreplace").decode(), flush=True)
    except BrokenPipeError:
        # The reader has gone. Python flushes standard output once more at exit: that must not fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return status


def contents(name: str) -> bytes:
    """The bytes of a file, up to one more than the largest certificate; UnreadableError if there
    are none."""
    try:
        with Path(name).open("rb") as file:
            return file.read(4_000_001)  # what is longer is refused: a device has no end
    except (OSError, ValueError) as error:
        raise UnreadableError(
            f"{name} cannot be read: {getattr(error, 'strerror', None) or error}"
        ) from None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
