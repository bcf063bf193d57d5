"""documentation/index.html: the page a person reads, made from the component itself."""

from html import escape

from gyro_cosim.component import Variable
from gyro_cosim.component.integration import METHODS

from .reference import STEP
from .table import Table

__all__ = ["html"]

STYLE = """body { font-family: sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; line-height: 1.45; }
table { border-collapse: collapse; width: 100%; } th, td { border-bottom: 1px solid #ccc; padding: .25em .6em; text-align: left; }
td.number { text-align: right; white-space: nowrap; } pre { background: #f3f6fa; padding: 1em; overflow-x: auto; }"""


def html(table: Table, identifier: str, *, sources: bool) -> bytes:
    """The page: what the model is, its equations, signals and parameters, how it is integrated, how to build it again.

    Parameters
    ----------
    table : Table
        The FMU's variables.
    identifier : str
        The model identifier, which names the files of reference results.
    sources : bool
        Whether the FMU ships its sources.

    Returns
    -------
    bytes
        The file.
    """
    c = table.component
    order = METHODS[c.method].order
    blocks = [
        f"<h1>{escape(c.name)}, {escape(c.variant)}</h1>",
        f"<p>{escape(c.description)}. All numbers are SI.</p>",
        "<h2>Equations</h2>",
        f"<pre>{escape(c.equations)}</pre>",
    ]
    sections = (("Inputs", c.inputs), ("Outputs", c.outputs), ("States", c.states), ("Parameters", table.parameters))
    for title, rows in sections:
        if rows:
            blocks += [f"<h2>{title}</h2>", _table(rows, start=title != "Outputs")]
    if c.bonds:
        blocks.append("<h2>Connectors</h2><ul>")
        blocks += [
            f"<li>{escape(b.connector)}, {escape(b.axis)}: {escape(b.motion)} times {escape(b.effort)} is a power</li>"
            for b in c.bonds
        ]
        blocks.append("</ul>")
    blocks += [
        "<h2>Time integration</h2>",
        f"<p>Method {escape(c.method)}, order {order}. A communication step is divided evenly into internal steps no longer "
        f"than the parameter internal_step (start {c.internal_step:g} s). With the parameter tolerance above 0 each internal "
        "step is compared with two of half its length, and its length chosen so that they differ by no more than that, "
        "relative to nominal value and size of each state.</p>",
    ]
    if c.sample_period is not None:
        blocks.append(f"<p>The sampled part runs at every multiple of {c.sample_period:g} s, with the inputs of that moment.</p>")
    blocks += [
        "<h2>Reference results</h2>",
        f'<p><a href="reference/{identifier}_in.csv">Inputs</a>, held over communication steps of {STEP:g} s, and the '
        f'<a href="reference/{identifier}_ref.csv">outputs</a> after each step.</p>',
    ]
    if sources:
        blocks += [
            "<h2>Building it again</h2>",
            "<p>In the folder sources, which holds FMI's headers too: "
            f"<code>cc -O3 -std=c99 -ffp-contract=off -shared -fPIC -fvisibility=hidden "
            f"-o {identifier}.so fmu.c *_derivatives.c -lm</code>. "
            "sources/buildDescription.xml says the same to tools.</p>",
        ]
    blocks.append('<p>Licences: <a href="licenses/license.txt">license.txt</a>.</p>')
    body = "\n".join(blocks)
    head = f'<meta charset="utf-8"><title>{escape(c.name)} {escape(c.variant)}</title><style>{STYLE}</style>'
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body>\n{body}\n</body></html>\n'.encode()


def _table(rows: tuple[Variable, ...], *, start: bool) -> str:
    titles = ["Name", "Symbol", "Unit", *(["Start"] if start else []), "Meaning", "Source", "Range"]
    lines = ["<table><tr>" + "".join(f"<th>{t}</th>" for t in titles) + "</tr>"]
    for v in rows:
        limits = []
        if v.min is not None or v.max is not None:
            limits.append(f"{'' if v.min is None else f'{v.min:g}'} to {'' if v.max is None else f'{v.max:g}'}".strip())
        if v.assumed is not None:
            limits.append(f"assumed, {v.assumed[0]:g} to {v.assumed[1]:g}")
        cells = [escape(t) for t in (v.name, v.symbol, v.unit)]
        line = "".join(f"<td>{cell}</td>" for cell in cells)
        if start:
            line += f'<td class="number">{v.start:.10g}</td>'
        line += "".join(f"<td>{escape(cell)}</td>" for cell in (v.meaning, v.source, "; ".join(limits)))
        lines.append(f"<tr>{line}</tr>")
    return "\n".join([*lines, "</table>"])
