"""``python -m haptisym_check FILE SCENE.toml``: status 0 and the claim if the certificate proves it, 1 and what fails if not."""

import os
import sys
from pathlib import Path

from haptisym_check import RefusedError, check


def main(arguments: list[str]) -> int:
    """The exit status."""
    if len(arguments) != 2:
        print("usage: python -m haptisym_check FILE SCENE.toml", file=sys.stderr)
        return 2
    try:
        texts = []
        for name in arguments:
            with Path(name).open("rb") as file:
                texts.append(file.read(4_000_001))  # what is longer is refused: a device has no end
        said, status = check(*texts), 0
    except (RefusedError, OSError) as error:
        said, status = f"NOT proven: {error}", 1
    try:
        print(said, flush=True)
    except BrokenPipeError:  # whoever read has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
