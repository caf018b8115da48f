"""Runs pytest and ends the process at once.

Blender 4.5 as a module hangs when its interpreter shuts down, so the exit skips the shutdown.
"""

from __future__ import annotations

import os
import sys


def main() -> None:
    import pytest

    code = int(pytest.main(sys.argv[1:] or ["tests"]))
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    main()
