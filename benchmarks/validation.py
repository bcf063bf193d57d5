"""Print our numbers beside others' (docs/validation.md), as tables; under a minute.

python benchmarks/validation.py                       # all tables that need no files
python benchmarks/validation.py klingel               # one
python benchmarks/validation.py --profiles FOLDER     # with those of published profile files, gathered in a folder
python benchmarks/validation.py --write               # and put what was printed into the page

Exit code 1 where a number differs by more than it may.
"""

import argparse
import sys
from pathlib import Path

from validation_cases import TABLES, WITH_FILES, Table

PAGE = Path(__file__).parent.parent / "docs" / "validation.md"


def marks(name: str) -> tuple[str, str]:
    """What stands before and behind a table on the page."""
    return f"<!-- {name}, as benchmarks/validation.py wrote it -->\n", f"<!-- end of {name} -->\n"


def put(name: str, text: str) -> None:
    begin, end = marks(name)
    before, found, rest = PAGE.read_text(encoding="utf-8").partition(begin)
    _, ended, after = rest.partition(end)
    if not (found and ended):
        sys.exit(f"{PAGE} must have the marks {begin.strip()!r} and {end.strip()!r}")
    PAGE.write_text(f"{before}{begin}{text}{end}{after}", encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(description="Our numbers beside others'.")
    parser.add_argument("tables", nargs="*", help=f"of {', '.join((*TABLES, *WITH_FILES))}; all otherwise")
    parser.add_argument("--profiles", type=Path, metavar="FOLDER", help="where the published profile files are")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/validation.md")
    given = parser.parse_args()
    unknown = sorted(set(given.tables) - set(TABLES) - set(WITH_FILES))
    if unknown:
        parser.error(f"no table {unknown[0]!r}")
    if given.profiles is None and set(given.tables) & set(WITH_FILES):
        parser.error("these tables need --profiles FOLDER")
    missed = 0
    for name in given.tables or (*TABLES, *(WITH_FILES if given.profiles else ())):
        table: Table = TABLES[name]() if name in TABLES else WITH_FILES[name](given.profiles)
        print(f"\n{name}\n{table.markdown()}", end="", flush=True)
        for miss in table.misses():
            missed += 1
            print(f"MISSED {miss}")
        if given.write:
            put(name, table.markdown())
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
