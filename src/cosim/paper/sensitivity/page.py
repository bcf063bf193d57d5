"""The page of a study of draws, in Markdown: shares, what decides, derailments, the ranking, the best set of parameters."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ...sweeps.table import Table
from .draws import DRAW, Study
from .findings import Finding, Ranked, all_findings, margin_of, ranking, shown
from .statistics import wilson

BEST = 5  # draws that the ranking shows


def study_page(study: Study, table: Table) -> str:
    """Everything about one study."""
    rows_of_claims, ranked = all_findings(study, table), ranking(study, table)
    failed = int((table["status"] == "failed").sum())
    subject = study.subject
    kinds = ", each with " + " and ".join(subject.wheels) if len(subject.wheels) > 1 else ""
    text = [
        f"## {subject.name}: {study.draws} draws, seed {study.seed}",
        f"Latin hypercube over {len(subject.parameters)} open parameters{kinds}: {len(table)} rows, {failed} of them failed.",
        _claims(study, table, [f for f in rows_of_claims if not f.part]),
        "Parts of the claims:",
        _parts([f for f in rows_of_claims if f.part]),
        *_derailments(study, table),
        *_medians(study, table),
        f"Ranking by the parts that hold at once, of {sum(map(len, subject.claims.values()))}:",
        _ranking(study, table, ranked),
        "The best draws:",
        _best(study, table, ranked),
    ]
    return "\n\n".join(text) + "\n"


def table_of(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def _claims(study: Study, table: Table, rows_of_claims: Sequence[Finding]) -> str:
    head = ("claim", "wheels", "holds in", "95 %", "decided by (rank correlation)", "holds in the lowest and highest third of it",
            "at the middle")  # fmt: skip
    return table_of(head, (
        (f.claim, f.wheels, f"{f.share.count} of {f.share.judged}", f"{100 * f.share.low:.0f}..{100 * f.share.high:.0f} %",
         _decided(f), _thirds(study, table, f), "-" if f.middle is None else "holds" if f.middle else "does not")
        for f in rows_of_claims
    ))  # fmt: skip


def _decided(finding: Finding) -> str:
    """The parameters, and whether they move the margin only."""
    if not finding.deciding:
        return "none beyond chance"
    names = ", ".join(f"{shown(i.target)} ({i.rho:+.2f})" for i in finding.deciding)
    return names if finding.mixed else f"margin only: {names}"


def _thirds(study: Study, table: Table, finding: Finding) -> str:
    """Share of the claim where the parameter that decides it most is in the lowest, and in the highest, third of its range."""
    if not finding.deciding:
        return "-"
    target = finding.deciding[0].target
    here = (table["kind"] == DRAW) & (table["wheels"] == finding.wheels)
    value, margin = table[target][here], margin_of(study, table, finding.claim, finding.part)[here]
    (range_,) = (p for p in study.subject.parameters if p.target == target)
    low, high = value < range_.at(1 / 3), value > range_.at(2 / 3)
    words = []
    for third in (low, high):
        judged = margin[third][~np.isnan(margin[third])]
        words.append(f"{100 * np.mean(judged > 0.0):.0f} %" if judged.size else "-")
    return ", ".join(words)


def _parts(rows_of_claims: Sequence[Finding]) -> str:
    head = ("claim", "part", "wheels", "holds in", "95 %", "decided by")
    return table_of(head, (
        (f.claim, f.part, f.wheels, f"{f.share.count} of {f.share.judged}",
         f"{100 * f.share.low:.0f}..{100 * f.share.high:.0f} %",
         _decided(f))
        for f in rows_of_claims
    ))  # fmt: skip


def _derailments(study: Study, table: Table) -> list[str]:
    """Where a subject measures the climb of its flanges: how often it derails with the gyro off and on, at each speed."""
    cases = [c.partition(" off: climb")[0] for c in study.subject.measures if c.endswith(" off: climb")]
    rows = []
    for case in cases:
        for wheels in study.subject.wheels:
            here = (table["kind"] == DRAW) & (table["wheels"] == wheels)
            off, on = (table[f"{case} {gyro}: climb"][here] for gyro in ("off", "on"))
            judged = ~(np.isnan(off) | np.isnan(on))
            off, on = off[judged] > 1.0, on[judged] > 1.0
            shares = [wilson(int(x.sum()), int(judged.sum())) for x in (off, on)]
            rows.append((case, wheels, *(f"{s.count} ({100 * s.low:.0f}..{100 * s.high:.0f} %)" for s in shares),
                         int((off & ~on).sum()), int((~off & on).sum()), int(judged.sum())))  # fmt: skip
    head = ("case", "wheels", "derails off", "derails on", "off derails, on passes", "off passes, on derails", "draws")
    return ["Derailments:", table_of(head, rows)] if rows else []


def _medians(study: Study, table: Table) -> list[str]:
    """Of everything that is measured with the gyro off and on: its median over the draws, in either state."""
    units = study.subject.measures
    pairs = [
        (off, off.replace(" off: ", " on: ", 1)) for off in units if " off: " in off and not off.endswith((": climb", ": t"))
    ]
    rows = []
    for off, on in pairs:
        case, key = off.split(" off: ")
        for wheels in study.subject.wheels:
            here = (table["kind"] == DRAW) & (table["wheels"] == wheels)
            values = (float(np.nanmedian(table[column][here])) for column in (off, on))
            rows.append((case, key, wheels, units[off], *(f"{v:.3g}" if np.isfinite(v) else "most derail" for v in values)))
    head = ("case", "measure", "wheels", "unit", "off", "on")
    return ["Medians over the draws, gyro off and on:", table_of(head, rows)] if rows else []


def _ranking(study: Study, table: Table, ranked: Sequence[Ranked]) -> str:
    """What has a name, the middle, and the best draws, among the draws with the same wheels."""
    rows = []
    for wheels in study.subject.wheels:
        of = [r for r in ranked if r.wheels == wheels]
        drawn = [r for r in of if r.kind == DRAW]
        for r in [*(r for r in of if r.kind != DRAW), *drawn[:BEST]]:
            score = (r.parts, r.claims)
            better = sum((d.parts, d.claims) > score for d in drawn)
            equal = sum((d.parts, d.claims) == score and d is not r for d in drawn)
            rows.append((r.name, wheels, r.parts, r.claims, f"{better} of {len(drawn)}", equal))
    return table_of(("point", "wheels", "parts", "whole claims", "draws that do better", "others that do as well"), rows)


def _best(study: Study, table: Table, ranked: Sequence[Ranked]) -> str:
    """Values of the open parameters of the best draw for each kind of wheels, beside those that have names and the middle."""
    points = [r for r in ranked if r.kind != DRAW and r.kind in study.subject.named]
    for wheels in study.subject.wheels:
        points += [r for r in ranked if r.kind == DRAW and r.wheels == wheels][:1]
    head = ("parameter", "unit", "range", *(f"{r.name}, {r.wheels}" for r in points))
    rows = (
        (p.target, p.unit, f"{p.low:.4g}..{p.high:.4g}", *(f"{table[p.target][r.row]:.4g}" for r in points))
        for p in study.subject.parameters
    )
    return table_of(head, rows)


def _number(value: float) -> float | None:
    """`value` for JSON, which has no NaN."""
    return value if value == value else None


def document(study: Study, table: Table) -> dict[str, Any]:
    """The same as JSON holds it, with every correlation."""
    return {
        "subject": study.subject.name, "draws": study.draws, "seed": study.seed,
        "rows": len(table), "failed": int((table["status"] == "failed").sum()),
        "findings": [
            {"claim": f.claim, "part": f.part, "wheels": f.wheels, "count": f.share.count, "judged": f.share.judged,
             "low": f.share.low, "high": f.share.high, "middle": f.middle,
             "correlated": "truth" if f.mixed else "margin",
             "correlations": {i.target: {"rho": i.rho, "partial": _number(i.partial), "p": i.p} for i in f.influences}}
            for f in all_findings(study, table)
        ],
        "ranking": [
            {"point": r.name, "wheels": r.wheels, "parts": r.parts, "claims": r.claims,
             "values": {p.target: float(table[p.target][r.row]) for p in study.subject.parameters}}
            for r in ranking(study, table)
        ],
    }  # fmt: skip
