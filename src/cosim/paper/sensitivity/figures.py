"""Figures of a study of draws: how much of the open ranges each claim holds in, and which parameter moves which claim."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ... import figures
from .findings import Finding, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS_COLOUR = 0.45  # opacity of a part's bar beside that of a whole claim


def shares(found: Sequence[Finding]) -> "Figure":
    """Bars with their intervals: every claim, and below it its parts; one bar for each kind of wheels.

    Parts that say no more than their claim are left out: those of a claim with one part, or that holds in every draw.
    """
    rows = list(dict.fromkeys((f.claim, f.part) for f in found))
    sure = {c for c, _ in rows if all(f.share.count == f.share.judged for f in found if f.claim == c)}
    alone = sure | {claim for claim, _ in rows if sum(c == claim for c, _ in rows) == 2}
    rows = [(claim, part) for claim, part in rows if not (part and claim in alone)]
    wheels = list(dict.fromkeys(f.wheels for f in found))
    fig, axes = figures.figure(1, 1, (8.0, 1.2 + 0.19 * sum(_bars(found, row) for row in rows) + 0.1 * len(rows)))
    ax, ticks, labels, y = axes[0, 0], list[float](), list[str](), 0.0
    for claim, part in rows:
        y += 0.5 if part else 1.0
        here = [f for f in found if (f.claim, f.part) == (claim, part)]
        ticks.append(y + (len(here) - 1) / 2)
        labels.append(f"{part}" if part else f"{claim} (whole)" if claim not in alone else claim)
        for finding in here:
            s = finding.share
            share = s.count / s.judged if s.judged else 0.0
            colour = figures.COLOURS[wheels.index(finding.wheels)]
            ax.barh(y, share, height=0.85, color=colour, alpha=PARTS_COLOUR if part else 1.0)
            ax.plot([s.low, s.high], [y, y], color="0.15", linewidth=1.0, solid_capstyle="butt")
            ax.text(s.high + 0.01, y, f"{s.count} of {s.judged}", fontsize=7, va="center")
            y += 1.0
    ax.set_yticks(ticks, labels, fontsize=8)
    for label, (_, part) in zip(ax.get_yticklabels(), rows, strict=True):
        label.set_fontweight("normal" if part else "bold")
    ax.set_ylim(y, 0.0)
    ax.set_xlim(0.0, 1.14)
    ax.set_xticks(np.linspace(0.0, 1.0, 6), [f"{100 * x:.0f} %" for x in np.linspace(0.0, 1.0, 6)])
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("share of the draws from the open parameters' ranges, with 95 % intervals")
    for name in wheels:
        ax.barh(-5.0, 0.0, color=figures.COLOURS[wheels.index(name)], label=name)
    ax.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(wheels), frameon=False)
    return fig


def _bars(found: Sequence[Finding], row: tuple[str, str]) -> int:
    return sum((f.claim, f.part) == row for f in found)


def correlations(found: Sequence[Finding]) -> "Figure":
    """Rank correlation of each parameter (rows) with the truth of each claim (columns); numbers where it is more than chance.

    Where nearly all draws agree it is the correlation with the claim's margin, and the column says so.
    """
    whole = [f for f in found if not f.part]
    wheels = list(dict.fromkeys(f.wheels for f in whole))
    whole = [f for name in wheels for f in whole if f.wheels == name]
    targets = list(dict.fromkeys(i.target for f in whole for i in f.influences))
    table = np.full((len(targets), len(whole)), np.nan)
    for column, finding in enumerate(whole):
        for influence in finding.influences:
            table[targets.index(influence.target), column] = influence.rho
    strength = np.nan_to_num(np.abs(table)).max(axis=1) if targets else np.zeros(0)
    order = np.argsort(-strength, kind="stable")
    fig, axes = figures.figure(1, 1, (2.6 + 0.72 * len(whole), 1.6 + 0.27 * len(targets)))
    ax = axes[0, 0]
    drawn = ax.imshow(table[order], cmap="RdBu_r", vmin=-1.0, vmax=1.0, aspect="auto")
    for row, place in enumerate(order):
        for column, finding in enumerate(whole):
            counts = {i.target: i for i in finding.influences if i.counts}
            if targets[place] in counts:
                rho = counts[targets[place]].rho
                ax.text(column, row, f"{rho:+.2f}", ha="center", va="center", fontsize=7,
                        color="white" if abs(rho) > 0.6 else "black")  # fmt: skip
    ax.set_yticks(range(len(targets)), [shown(targets[place]) for place in order], fontsize=8)
    ax.set_xticks(range(len(whole)), [f.claim if f.mixed else f"{f.claim}\nmargin" for f in whole], fontsize=9)
    ax.grid(visible=False)
    edges = np.flatnonzero([a.wheels != b.wheels for a, b in pairwise(whole)])
    for edge in edges:
        ax.axvline(edge + 0.5, color="0.15", linewidth=1.5)
    for name in wheels:
        places = [column for column, f in enumerate(whole) if f.wheels == name]
        ax.text(float(np.mean(places)), -0.8, name, ha="center", va="bottom", fontsize=9)
    fig.colorbar(drawn, ax=ax, label="Spearman's rank correlation with the claim's truth", pad=0.02)
    return fig
