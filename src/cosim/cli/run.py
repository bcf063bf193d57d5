"""cosim run: one run of a system, a short summary, results in files."""

from contextlib import ExitStack, nullcontext
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from ..coupling import algorithm
from ..errors import RunError
from ..keeping.last_word import LastWord
from ..master import Options, macro_steps, open_network
from ..master import run as run_network
from .assessments import assessed, tabulated
from .common import (
    AlgorithmName,
    AsJson,
    Degree,
    Exchanged,
    Gyro,
    InProcess,
    InputFiles,
    Parameters,
    ScenarioFile,
    Swaps,
    SystemName,
    Tolerance,
    Values,
    Vehicle,
    chosen_system,
    complain,
    console,
    needs,
    progress,
    say,
    seconds,
)
from .integrator_steps import followed, parsed
from .kept import closing
from .live import seen_live
from .provenance import origin
from .reference import driven, read_reference_option
from .rescue import Rescue
from .results import Files
from .robust import STARTS, Conditions, prepared
from .run_options import one_of, pacer_of, substeps_of
from .settings import words
from .summary import document, summary_lines
from .trust import certainty, certainty_document, certainty_words

ISOLATE = (
    "run every FMU in a process of its own, which cannot take this one down: whatever it does, the results are kept; on Linux it "
    "gets no new rights and at most half of the memory"
)


def command(
    system: SystemName,
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    model_exchange: Exchanged = None,
    step: Annotated[str | None, typer.Option(metavar="TIME", help="macro step, such as 1ms")] = None,
    start: Annotated[
        str | None, typer.Option(metavar="TIME", help="beginning of the run; 0 where the system does not say")
    ] = None,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="end of the run, such as 60 or 2min")] = None,
    algorithm_: AlgorithmName = "jacobi",
    degree: Degree = 1,
    sequence: Annotated[
        str, typer.Option(metavar="A,B,...", help="sequence of stepping for gauss-seidel; else chosen by dependence")
    ] = "",
    substeps: Annotated[
        list[str] | None, typer.Option(metavar="COMPONENT=N", help="a component that does each macro step in N smaller ones")
    ] = None,
    loops: Annotated[str, typer.Option(metavar="solve|refuse", help="what to do with algebraic loops")] = "solve",
    adaptive: Annotated[float | None, typer.Option(metavar="TOL", help="adapt the macro step: error of each step")] = None,
    estimate: Annotated[
        str | None, typer.Option(metavar="HOW", help="error estimate of --adaptive: doubling (the default) or energy")
    ] = None,
    certify: Annotated[
        bool, typer.Option("--certify", help="estimate the coupling error of every output and the stability margin")
    ] = False,
    robust: Annotated[
        bool, typer.Option("--robust", help="ask the verdicts again with half the steps, other starts, another form of the model")
    ] = False,
    starts: Annotated[int | None, typer.Option(metavar="N", help=f"starts of --robust; {STARTS} otherwise")] = None,
    within: Annotated[
        list[str] | None,
        typer.Option(metavar="COMPONENT.VARIABLE=TOL", help="how far a start of --robust may be away: vehicle.angle=1mrad"),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="of the starts of --robust; 1 otherwise")] = None,
    assess: Annotated[
        bool, typer.Option("--assess", help="print the table by which a field judges the run, such as EN 14363's of a vehicle")
    ] = False,
    tolerance: Tolerance = None,
    in_process: InProcess = False,
    isolate: Annotated[bool, typer.Option("--isolate", help=ISOLATE)] = False,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="pace the macro steps to the wall clock, and report on it")
    ] = False,
    overrun: Annotated[
        str | None, typer.Option(metavar="WHAT", help="a step that is late with --realtime: count (the default), skip or stop")
    ] = None,
    priority: Annotated[
        int | None, typer.Option(metavar="N", help="real-time priority 1 to 99 with --realtime, where the system allows it")
    ] = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE", help="write the results to this .csv, .mat, .parquet or .mf4; again for another"),
    ] = None,
    select: Annotated[
        list[str] | None, typer.Option(metavar="PATTERN", help="record these signals only; * and ? are wild: 'gyro.*'")
    ] = None,
    inner: Annotated[
        list[str] | None,
        typer.Option(
            "--integrator-steps", metavar="COMPONENT=FILE", help="write each step of this FMU's own integrator to a file, too"
        ),
    ] = None,
    record_every: Annotated[int, typer.Option(metavar="N", help="record every N-th macro step")] = 1,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="draw the results, e.g. into a .png file")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FILE", help="write an .html page that shows the run and runs it again")
    ] = None,
    offered: Annotated[
        str | None,
        typer.Option("--report-variants", metavar="all|none|A,B", help="what the page has for the exchanged part; all else"),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="serve a page on this machine alone that shows the run as it goes on, and steers it")
    ] = False,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="write the state of the run to this file from time to time")
    ] = None,
    every: Annotated[str | None, typer.Option(metavar="TIME", help="simulated time between checkpoints; 10 s otherwise")] = None,
    resume: Annotated[Path | None, typer.Option(metavar="FILE", help="go on from a checkpoint of the same run")] = None,
    inputs: InputFiles = None,
    scenario: ScenarioFile = None,
    reference: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="compare with the results in this file; exit code 1 if they differ"),
    ] = None,
    tolerance_band: Annotated[
        str | None,
        typer.Option(metavar="SHARE[,TIME]", help="of --reference: share of the largest value, and time either way; 1e-3 else"),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Run a built-in system, an .ssd, .ssp or .toml file, or an .fmu alone.

    Without options `cosim run wheel-pair` is the paper's case of figure 4: v = 10 m/s, rotor at 100 rpm, starting at
    y = 0.001 m and psi = 0.314 rad.
    """
    from ..master.adaptive import Adaptive
    from ..master.checkpoint import Checkpoint, Resume
    from ..master.locking import in_use

    plan = chosen_system(
        system, gyro, set_, vehicle=vehicle, swaps=swap, params=params, exchanged=model_exchange, tolerance=tolerance
    )
    plan = driven(plan, inputs, scenario)
    chosen = algorithm(algorithm_, degree, words(sequence))
    h, end = seconds(step, "--step", plan.step), seconds(stop, "--stop", plan.stop)
    begin = seconds(start, "--start", plan.start)
    steps = macro_steps(h, end, begin)
    if loops not in ("solve", "refuse"):
        raise ValueError(f"--loops must be solve or refuse, got {loops!r}")
    if isolate and in_process and not any(component.source.endswith(".fmu") for component in plan.components):
        raise ValueError("--isolate has no effect with --in-process where no component is an FMU file")
    one_of("--estimate", estimate, ("doubling", "energy"))
    one_of("--overrun", overrun, ("count", "skip", "stop"))
    if priority is not None and not 1 <= priority <= 99:
        raise ValueError(f"--priority must be 1 to 99, got {priority}")
    interval = seconds(every, "--every", 10.0)
    needs("--estimate", estimate, "--adaptive", adaptive is not None)
    needs("--overrun", overrun, "--realtime", realtime)
    needs("--priority", priority, "--realtime", realtime)
    needs("--report-variants", offered, "--report", report is not None)
    needs("--every", every, "--checkpoint", checkpoint is not None)
    if certify and (select or record_every != 1 or resume is not None):
        raise ValueError("--certify needs all results of the whole run")
    for option, value in (("--starts", starts), ("--within", within), ("--seed", seed)):
        needs(option, value, "--robust", robust)
    if robust and (adaptive is not None or select or checkpoint is not None or resume is not None or realtime):
        raise ValueError("--robust needs an even macro step and all results of the whole run, as fast as it goes")
    if live and (robust or certify):
        raise ValueError("--live shows one run, --robust and --certify make several")
    inner_files = parsed(inner or (), output or ())
    own = (*(output or ()), *inner_files.values(), *filter(None, [plot, report, checkpoint, resume]))
    where_from = origin(plan, written=own) if output or inner_files or as_json else None
    files = Files(tuple(output or ()), plot, where_from, report, offered or "all")
    files.check()
    if inner and (checkpoint is not None or resume is not None):
        raise ValueError("--integrator-steps needs the whole run, it has no effect with --checkpoint or --resume")
    how: Any = None if adaptive is None else Adaptive(adaptive, estimate or "doubling")  # type: ignore[arg-type]
    pacer = pacer_of(h, steps, overrun or "count", priority or 0, adaptive) if realtime else None
    failure: RunError | None = None
    rescue = Rescue(files)
    with (
        in_use((*files.all, *inner_files.values(), *filter(None, [checkpoint]))),
        LastWord(rescue.word),
        open_network(plan, in_process=in_process, isolate=isolate, substeps=substeps_of(substeps)) as network,
        closing(),
        ExitStack() as live_view,
    ):
        told_steps = followed(inner_files, network)
        if loops == "refuse":
            network.refuse_loops()
        again = (
            prepared(network, h, within or (), STARTS if starts is None else starts, 1 if seed is None else seed)
            if robust
            else None
        )
        against = read_reference_option(reference, tolerance_band, plan, network.names)
        record = files.recording(
            select or (), record_every, steps * len(network.names),
            always=checkpoint is not None or resume is not None, never=certify,
        )  # fmt: skip
        seen = live_view.enter_context(
            seen_live(
                live, network, step=h, start=begin, stop=end, select=select or (), every=record_every, pacer=pacer,
                steers=adaptive is None and checkpoint is None and resume is None,
            )
        )  # fmt: skip
        options = Options(
            record=record,
            adaptive=how,
            checkpoint=None if checkpoint is None else Checkpoint(checkpoint, interval),
            resume=None if resume is None else Resume(resume),
            visitor=seen.visitor,
        )
        with progress(f"running {plan.name}") as show:
            try:
                with pacer or nullcontext():
                    run = run_network(
                        network, chosen, h, end, start=begin, options=options, progress=None if pacer else show,
                        before_step=pacer, begun=partial(rescue.begun, streamed=record.stream),
                    )  # fmt: skip
            except RunError as error:
                if error.partial is None:
                    raise
                failure, run = error, error.partial
        live_view.close()
        files, kept = seen.kept(plan, files, float(run.trajectory.t[-1]), ended=run.status == "interrupted")
        found = assessed(run.trajectory)
        written = kept + files.write(run, found, record.stream)  # first of all: what follows may be the end of the process
        written += [one.write(files.seen_from(one.place)) for one in told_steps]
        rescue.written()
        if failure is not None:
            for file in written:
                console().print(f"kept the results up to t = {run.trajectory.t[-1]:g} s in {file}")
            if pacer is not None:
                console().print(pacer.report().words())
            return complain(str(failure), 1)
        known = certainty(network, run, end, certify=certify)
        sure = certainty_words(run, known)
        written += files.page(run, found, sure, record_every)
        told = document(run, found) | certainty_document(run, known)
        if where_from is not None:
            told["origin"] = where_from.document()
        lines = summary_lines(run, in_process, found) + (tabulated(found) if assess else []) + sure
        if again is not None:
            how_ran = Conditions(chosen, begin, end, in_process, isolate, substeps_of(substeps), record_every)
            asked = again.ask(run, found, how_ran)
            told["robust"] = again.document(asked)
            lines += again.words(asked)
        if against is not None:
            judgement = against.ask(run)
            told["reference"] = against.document(judgement)
            lines += against.words(judgement)
        if pacer is not None:
            told["realtime"] = pacer.report().document()
            lines.append(pacer.report().words())
        say(as_json, lambda: told, *lines, *(f"wrote {file}" for file in written))
        if certify and run.status == "ended":
            console().print("cosim: no certificate: the run has ended before its time", soft_wrap=True)
        if known.failure:
            console().print(f"cosim: {known.failure}", soft_wrap=True)
        turned = again is not None and not asked.decidable
        turned = turned or (against is not None and not judgement.verdict)
        return 0 if run.status in ("done", "ended") and not known.failure and not turned else 1
