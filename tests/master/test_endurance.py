"""A process that lives long: one run after another leaves nothing behind. At length: benchmarks/endurance.py."""

from pathlib import Path

import pytest

from gyro_cosim import simulate, system

OWN = Path("/proc/self")


@pytest.mark.skipif(not OWN.is_dir(), reason="counts what Linux tells of a process")
def test_runs_leave_no_map_descriptor_or_thread_behind() -> None:
    """Ten maps of a library that formats messages were left by each run once: no library could be loaded after 6 526."""

    def counts() -> tuple[int, ...]:
        libraries = [line for line in (OWN / "maps").read_text().splitlines() if ".so" in line]
        return len(libraries), len(list((OWN / "fd").iterdir())), len(list((OWN / "task").iterdir()))

    plan = system("wheel-pair")
    simulate(plan, stop=0.01)  # loads what is loaded once
    before = counts()
    for _ in range(5):
        simulate(plan, stop=0.01)
    assert counts() == before
