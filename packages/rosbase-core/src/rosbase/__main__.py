"""`python -m rosbase` is the command `rosbase`, of the Python that is named."""

import sys

from rosbase.cli import main

sys.exit(main())
