"""`python -m gyro_cosim` is the command `cosim`."""

import sys

from .cli import main

sys.exit(main())
