"""The Reference-FMUs of the Modelica Association, where they are at hand: REFERENCE_FMUS is a folder of the compiled FMUs,
REFERENCE_SOURCES a checkout of their repository. Nothing of them is kept here.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PLACES = [os.environ.get(name, "") for name in ("REFERENCE_FMUS", "REFERENCE_SOURCES")]


@pytest.mark.slow
@pytest.mark.skipif(not all(PLACES), reason="REFERENCE_FMUS and REFERENCE_SOURCES must be set")
def test_every_reference_fmu_meets_its_results_by_both_interfaces() -> None:
    script = Path(__file__).parents[2] / "benchmarks" / "reference_fmus.py"
    done = subprocess.run([sys.executable, script, *PLACES], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("CoSimulation") >= 14
    assert done.stdout.count("ModelExchange") >= 14
