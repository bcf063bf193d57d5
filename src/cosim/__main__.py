"""`python -m gyro_cosim` is the command `cosim`."""

import sys

from gyro_cosim.cli import main

sys.exit(main())
