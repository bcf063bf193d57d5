"""Where the one importable package, `gyro_cosim`, finds its parts: folders at the top of the repository.

Everything else about the project stands in pyproject.toml. Why it is so: docs/decisions/0008-one-package-of-our-own.md.
Two files lie beside the package: who imports a name of before 0.2.0 is told the new one (src/_gyro_cosim_old_names.py).
"""

import shutil
from pathlib import Path

from setuptools import Distribution, find_packages, setup  # before distutils, which it brings along

from distutils.command.install_data import install_data  # isort: skip

FOLDERS = {
    "gyro_cosim": "src/cosim",
    "gyro_cosim.component": "component",
    "gyro_cosim.vehicle": "vehicle",
    "gyro_cosim.gyro_unit": "gyro_unit",
    "gyro_cosim.fmus": "fmus",
}

BESIDE = ["src/_gyro_cosim_old_names.py", "src/gyro_cosim_old_names.pth"]


class BesideThePackage(install_data):
    """Data files go where packages go, which is where Python reads .pth files: in wheels and in editable installs."""

    def finalize_options(self) -> None:
        """Take the packages' folder for that of the data."""
        self.set_undefined_options("install", ("install_lib", "install_dir"))
        super().finalize_options()


class WithData(Distribution):
    """An editable install copies data files if the distribution answers so: setuptools asks, but gives it no answer."""

    def has_data(self) -> bool:
        """Whether there are data files."""
        return bool(self.data_files)


shutil.rmtree("build/lib", ignore_errors=True)  # what an earlier build has left would go into the wheel: files that are no more
Path("build").mkdir(exist_ok=True)  # metadata made on the way: beside the sources it would be found instead of the installed one

setup(
    package_dir=FOLDERS,
    packages=[".".join(filter(None, (name, part))) for name, folder in FOLDERS.items() for part in ("", *find_packages(folder))],
    data_files=[("", BESIDE)],
    distclass=WithData,
    cmdclass={"install_data": BesideThePackage},
    options={"egg_info": {"egg_base": "build"}},
)
