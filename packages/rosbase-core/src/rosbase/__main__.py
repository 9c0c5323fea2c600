"""Run the command `rosbase` with a chosen Python: `python -m rosbase`."""

import sys

from rosbase.cli import main

sys.exit(main())
