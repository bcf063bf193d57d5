"""Lay the package out as one tree of links, build/tree/gyro_cosim, for tools that read files and follow no import hook.

mypy and import-linter look for a package's parts inside its folder; here the parts stand at the top of the repository, and
setup.py maps them. Editors find the same tree through pyproject.toml. Links, so that what a tool says of a file is the file.
"""

import os
import runpy
import shutil
import sys
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[1]
TREE = ROOT / "build" / "tree"


def lay(link: Path, target: Path) -> None:
    """`link` becomes another name of `target`, a file or a folder."""
    if sys.platform == "win32" and target.is_dir():  # there a link needs a right that a junction does not
        import _winapi

        _winapi.CreateJunction(str(target), str(link))
    elif sys.platform == "win32":
        os.link(target, link)
    else:
        link.symlink_to(target)


def main() -> None:
    """Lay the tree anew."""
    with mock.patch("setuptools.setup"):
        folders = runpy.run_path(str(ROOT / "setup.py"))["FOLDERS"]
    package = TREE / "gyro_cosim"
    if package.exists():
        for entry in package.iterdir():
            if entry.name == "__pycache__":
                shutil.rmtree(entry)
            else:
                entry.rmdir() if sys.platform == "win32" and entry.is_dir() else entry.unlink()
    package.mkdir(parents=True, exist_ok=True)
    for name, folder in folders.items():
        _, _, part = name.partition(".")
        if part:
            lay(package / part, ROOT / folder)
        else:
            for entry in (ROOT / folder).iterdir():
                if entry.name != "__pycache__":
                    lay(package / entry.name, entry)


if __name__ == "__main__":
    main()
