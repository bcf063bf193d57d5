"""Lay the package out as one tree of links, build/tree/gyro_cosim, for tools that read files and follow no import hook.

    python .ci/tree.py [TOOL ARGUMENT ...]      lay the tree; run a tool of this Python's environment on it, such as mypy

mypy and import-linter look for a package's parts inside its folder; here the parts stand at the top of the repository, and
setup.py maps them. Links, so that what a tool says of a file is the file.
"""

import os
import runpy
import shutil
import subprocess
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


def wanted() -> dict[Path, Path]:
    """Every link of the tree and what it leads to, as setup.py maps folders and files."""
    with mock.patch("setuptools.setup"):
        layout = runpy.run_path(str(ROOT / "setup.py"))
    links = {TREE / Path(file).name: ROOT / file for file in layout["BESIDE"]}
    for name, folder in layout["FOLDERS"].items():
        _, _, inside = name.partition(".")
        if inside:
            links[TREE / "gyro_cosim" / inside] = ROOT / folder
        else:
            links |= {
                TREE / "gyro_cosim" / entry.name: entry for entry in (ROOT / folder).iterdir() if entry.name != "__pycache__"
            }
    return links


def lay_tree() -> None:
    """Remove the links that are wrong, lay those that are missing: a tool that is reading the others is not disturbed."""
    links = wanted()
    (TREE / "gyro_cosim").mkdir(parents=True, exist_ok=True)
    for entry in (*TREE.iterdir(), *(TREE / "gyro_cosim").iterdir()):
        if entry.name == "__pycache__":
            shutil.rmtree(entry)
        elif entry in links and entry.exists() and entry.samefile(links[entry]):
            del links[entry]
        elif entry != TREE / "gyro_cosim":
            entry.rmdir() if sys.platform == "win32" and entry.is_dir() else entry.unlink()
    for link, target in links.items():
        lay(link, target)


def main() -> int:
    """Lay the tree, and run the tool that is named behind it, if there is one."""
    lay_tree()
    if not sys.argv[1:]:
        return 0
    tool = shutil.which(sys.argv[1], path=str(Path(sys.executable).parent))
    if tool is None:
        sys.exit(f"{sys.argv[1]} must be installed in the environment of {sys.executable}, it is not")
    return subprocess.run([tool, *sys.argv[2:]], env={**os.environ, "PYTHONPATH": str(TREE)}, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
