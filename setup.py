"""Where the one importable package, `gyro_cosim`, finds its parts: folders at the top of the repository.

Everything else about the project stands in pyproject.toml. Why it is so: docs/decisions/0008-one-package-of-our-own.md.
"""

from pathlib import Path

from setuptools import find_packages, setup

FOLDERS = {
    "gyro_cosim": "src/cosim",
    "gyro_cosim.component": "component",
    "gyro_cosim.vehicle": "vehicle",
    "gyro_cosim.gyro_unit": "gyro_unit",
    "gyro_cosim.fmus": "fmus",
}

Path("build").mkdir(exist_ok=True)  # metadata made on the way: beside the sources it would be found instead of the installed one

setup(
    package_dir=FOLDERS,
    packages=[".".join(filter(None, (name, part))) for name, folder in FOLDERS.items() for part in ("", *find_packages(folder))],
    options={"egg_info": {"egg_base": "build"}},
)
