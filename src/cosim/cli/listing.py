"""cosim list: what is installed."""

from rich.table import Table

from .. import ssp
from ..coupling import ALGORITHMS, algorithm
from ..systems import catalogue
from .common import AsJson, say


def command(as_json: AsJson = False) -> int:
    """List the built-in systems, components with their variants, and coupling algorithms."""
    systems = {name: ssp.read(file).description for name, file in catalogue.systems().items()}
    components = {name: list(variants) for name, variants in catalogue.components().items()}
    algorithms = {name: [algorithm(name, degree).order for degree in range(3)] for name in ALGORITHMS}
    tables: list[str | Table] = []
    for title, rows in (
        ("system", systems.items()),
        ("component", [(name, "variants " + ", ".join(variants)) for name, variants in components.items()]),
        ("algorithm", [(n, f"order {', '.join(map(str, o))} with input degree 0, 1, 2") for n, o in algorithms.items()]),
    ):
        table = Table(title, "", box=None, pad_edge=False)
        table.columns[0].min_width = 14
        for row in rows:
            table.add_row(*row)
        tables += [table, ""]
    say(as_json, lambda: {"systems": systems, "components": components, "algorithms": algorithms}, *tables[:-1])
    return 0
