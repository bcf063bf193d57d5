"""The checker: silent about our own FMUs, one line for each fault put into one, and never brought down by a binary."""

import re
import shutil
import subprocess
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import clock_fmus
import pytest
from fmu_models import COMPONENTS

from gyro_cosim.check import Finding, check_fmu
from gyro_cosim.fmus.compiler import FLAGS, host, host_compiler
from gyro_cosim.slaves.fmi.description import load


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize(
    "name",
    [
        name if name in ("gyro_unit:nonlinear", "sampled", "gain") else pytest.param(name, marks=pytest.mark.slow)
        for name in COMPONENTS
        if name != "implicit growth"  # its derivative is unbounded: the probes' small steps say nothing there
    ],
)
def test_our_own_fmus_have_no_fault(built: Callable, name: str, version: str) -> None:
    assert worse_than_notes(check_fmu(built(name, version)[1])) == []


@pytest.fixture
def changed(built: Callable, tmp_path: Path) -> Callable[..., Path]:
    """An FMU of plain() with members rewritten: changed("2", {"modelDescription.xml": function of text}, c={...})."""

    def make(
        version: str, edits: dict[str, Callable[[str], str]] | None = None, c: tuple[str, str, str] | None = None,
        name: str = "plain",
    ) -> Path:  # fmt: skip
        _, path, _ = built(name, version)
        folder = tmp_path / "fmu"
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        for member, edit in (edits or {}).items():
            text = (folder / member).read_text()
            assert edit(text) != text, "the mutation must change something"
            (folder / member).write_text(edit(text))
        if c is not None:
            file, old, new = c
            source = folder / "sources" / file
            text = source.read_text()
            assert text.count(old) >= 1, "the mutation must change something"
            source.write_text(text.replace(old, new, 1))
            library = next(folder.glob("binaries/*/*.so"))
            files = ["fmu.c", "rhs_derivatives.c", "output_derivatives.c"]
            subprocess.run([*compiler(), "-O1", *FLAGS, "-shared", "-fPIC", "-o", str(library), *files, "-lm"],
                           cwd=folder / "sources", check=True)  # fmt: skip
        result = tmp_path / "changed.fmu"
        with zipfile.ZipFile(result, "w") as archive:
            for file in sorted(p for p in folder.rglob("*") if p.is_file()):
                archive.write(file, file.relative_to(folder).as_posix())
        return result

    return make


def compiler() -> list[str]:
    import sys

    return host_compiler() or [sys.executable, "-m", "ziglang", "cc", "-target", host().target]


def rules(findings: list[Finding], severity: str = "fault") -> set[str]:
    for finding in findings:
        assert "\n" not in str(finding)
    return {finding.rule for finding in findings if finding.severity == severity}


def worse_than_notes(findings: list[Finding]) -> list[Finding]:
    return [finding for finding in findings if finding.severity != "note"]


def replace(pattern: str, new: str) -> Callable[[str], str]:
    return lambda text: re.sub(pattern, new, text, count=1, flags=re.DOTALL)


DESCRIPTION = "modelDescription.xml"
MUTANTS_OF_TEXT = {
    "wrong derivative index, FMI 2": ("2", r'derivative="1"', 'derivative="2"', "derivative"),
    "wrong derivative index, FMI 3": ("3", r'derivative="1"', 'derivative="2"', "derivative"),
    "min above start": ("2", r'min="0.0" max="1000000.0"', 'min="50.0" max="1000000.0"', "start", "warning"),
    "min above max": ("3", r'min="0.0" max="1000000.0"', 'min="9.0" max="1.0"', "bounds"),
    "nominal 0": ("2", r'nominal="2.0"', 'nominal="0.0"', "nominal"),
    "start not that of the binary": ("2", r'start="0.3"', 'start="0.31"', "start"),
    "missing dependency": ("2", r'(<Unknown index="4" dependencies=")1 3"', r'\g<1>1"', "dependencies"),
    "unknown unit": ("3", r'(<Float64 name="u".*?unit=)"rad/s2"', r'\g<1>"furlong"', "validation"),
    "no such causality": ("2", r'causality="input"', 'causality="inputs"', "validation"),
    "another guid": ("2", r'guid="\{', 'guid="{x', "instance"),
    "other model identifier": ("3", r'modelIdentifier="pendulum_plain"', 'modelIdentifier="pendulum"', "binary"),
    "stop before start": ("2", r'startTime="0.0"', 'startTime="20.0"', "experiment", "warning"),
    "not XML": ("2", r"<ModelVariables>", "<ModelVariables", "description"),
}


@pytest.mark.parametrize("case", MUTANTS_OF_TEXT)
def test_faults_in_the_description_are_named(changed: Callable[..., Path], case: str) -> None:
    version, pattern, new, rule, *severity = MUTANTS_OF_TEXT[case]
    assert rule in rules(check_fmu(changed(version, {DESCRIPTION: replace(pattern, new)})), *severity)


MUTANTS_OF_CODE = {  # (file, old, new, rule)
    "directional derivatives of the wrong sign": (
        "derivatives.c",
        "[v->index] += seed[i];\n    }\n    if (!adjoint)",
        "[v->index] -= seed[i];\n    }\n    if (!adjoint)",
        "sensitivities",
    ),
    "adjoint derivatives forget the state": (
        "derivatives.c",
        "x[i] += more_x[i]",
        "x[i] += 0 * more_x[i]",
        "sensitivities",
    ),
    "restore forgets the state": (
        "core.c",
        "m->s = *saved;",
        "double kept = m->s.x[0]; m->s = *saved; m->s.x[0] = kept;",
        "states",
    ),
    "instances share a state": (
        "step.c",
        "if (m->ask) m->ask(m, t, 0);",
        "static double shared; m->s.x[0] += shared; shared += 1e-9;",
        "instances",
    ),
    "reset keeps the inputs": (
        "fmi2.c",
        "    to_start(m);\n    return fmi2OK;",
        "    double kept = m->s.x[0]; to_start(m); m->s.x[0] = kept;\n    return fmi2OK;",
        "reset",
    ),
    "crash in a step": (
        "step.c",
        "if (m->ask) m->ask(m, t, 0);",
        "*(volatile int *)0 = 1;",
        "instance",
    ),
    "crash at the bound of a parameter": (
        "core.c",
        "case PARAMETER: m->s.p[v->index] = value[i], m->P_known = 0; break;",
        "case PARAMETER: m->s.p[v->index] = value[i], m->P_known = 0; if (value[i] == 1e6) abort(); break;",
        "bounds",
    ),
    "crash after a wrong call": (
        "fmi2.c",
        "    CHECK(RUNNING);\n    Status status = get(",
        "    if (vr[0] > 100000) *(volatile int *)0 = 1;\n    CHECK(RUNNING);\n    Status status = get(",
        "misuse warning",
    ),
    "exit": (
        "fmi2.c",
        "to_initialized(m);",
        "to_initialized(m); exit(0);",
        "instance",
    ),
    "NaN at a bound": (
        "core.c",
        "case OUTPUT: value[i] = outputs(m)[v->index]; break;",
        "case OUTPUT: value[i] = outputs(m)[v->index] + (m->s.p[0] == 0 ? NAN : 0); break;",
        "bounds warning",
    ),
    "derivative not that of the state": (
        "core.c",
        "value[i] = derivatives(m)[v->index]",
        "value[i] = 2 * derivatives(m)[v->index]",
        "slope warning",
    ),
}


FAST = ("directional derivatives of the wrong sign", "restore forgets the state", "crash in a step")


@pytest.mark.parametrize("case", [c if c in FAST else pytest.param(c, marks=pytest.mark.slow) for c in MUTANTS_OF_CODE])
def test_faults_of_the_binary_are_named_and_do_no_harm(changed: Callable[..., Path], case: str) -> None:
    """Wrong results, crashes and exits of the binary; the caller lives on to say so."""
    *mutation, expected = MUTANTS_OF_CODE[case]
    rule, *severity = expected.split()
    assert rule in rules(check_fmu(changed("3" if "adjoint" in case else "2", c=tuple(mutation))), *severity)


def test_an_fmu_that_steps_on_a_grid_of_its_own_is_no_fault(changed: Callable[..., Path]) -> None:
    """Foreign FMUs often have a fixed internal step, and do not move over a shorter one."""
    coarse = ("fmi2.c", "    Status status = do_step(", "    if (h < 1e-4) return fmi2OK;\n    Status status = do_step(")
    assert worse_than_notes(check_fmu(changed("2", c=coarse))) == []


def test_a_binary_that_hangs_is_stopped(changed: Callable[..., Path]) -> None:
    loop = "for (volatile int i = 0; ; i++) {} to_initialized(m);"
    faults = check_fmu(changed("2", c=("fmi2.c", "to_initialized(m);", loop)), timeout=1.0)
    assert any("does not come back" in fault.message for fault in faults)


def test_files_that_are_no_fmus_are_refused_in_one_line(built: Callable, tmp_path: Path) -> None:
    text = tmp_path / "text.fmu"
    text.write_text("hello")
    assert rules(check_fmu(text)) == {"archive"}
    cut = tmp_path / "cut.fmu"
    cut.write_bytes(built("gain")[1].read_bytes()[:5000])
    assert rules(check_fmu(cut)) == {"archive"}
    empty = tmp_path / "empty.fmu"
    with zipfile.ZipFile(empty, "w") as archive:
        archive.writestr("readme", "")
    assert rules(check_fmu(empty)) == {"archive"}
    outside = tmp_path / "outside.fmu"
    shutil.copy(built("gain")[1], outside)
    with zipfile.ZipFile(outside, "a") as archive:
        archive.writestr("../evil", "")
    assert rules(check_fmu(outside)) == {"archive"}
    with pytest.raises(ValueError, match="must be a file"):
        check_fmu(tmp_path / "missing.fmu")
    with pytest.raises(ValueError, match="timeout must be positive"):
        check_fmu(text, timeout=0)


def test_the_door_is_that_of_a_run(built: Callable, tmp_path: Path) -> None:
    """What `run` refuses, `check` refuses for the same reason, at once: bombs, links, entities, members over one another."""
    gain = built("gain")[1]

    def with_member(name: str, data: bytes = b"", mode: int = 0o100644) -> Path:
        file = tmp_path / f"{len(list(tmp_path.iterdir()))}.fmu"
        with zipfile.ZipFile(gain) as source, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as target:
            for member in source.namelist():
                if member != name:
                    target.writestr(member, source.read(member))
            extra = zipfile.ZipInfo(name)
            extra.create_system, extra.external_attr, extra.compress_type = 3, mode << 16, zipfile.ZIP_DEFLATED
            target.writestr(extra, data)
        return file

    with zipfile.ZipFile(gain) as archive:
        text = archive.read(DESCRIPTION).decode()
    doctype = text.replace("<fmiModelDescription", '<!DOCTYPE a [<!ENTITY b "c">]><fmiModelDescription', 1).encode()
    for file, rule, says in (
        (with_member("resources/zeros", bytes(70 << 20)), "archive", "must not unpack to more than 200 times its size"),
        (with_member("resources/link", b"/etc/passwd", 0o120777), "archive", "is a symbolic link"),
        (with_member("resources/pipe", b"", 0o010644), "archive", "is a device or the like"),
        (with_member("/".join("d" * 100)), "archive", "64 folders"),
        (with_member(DESCRIPTION, doctype), "description", "must have no document type declaration"),
    ):
        (finding,) = check_fmu(file)
        assert (finding.rule, finding.severity) == (rule, "fault")
        assert says in finding.message
        with pytest.raises(ValueError, match=re.escape(says)):
            load(str(file))


def test_many_members_are_looked_at_in_linear_time(built: Callable, tmp_path: Path) -> None:
    """Each was counted among all: 20 000 members took minutes."""
    file = tmp_path / "many.fmu"
    with zipfile.ZipFile(file, "w") as target:
        for k in range(20_000):
            target.writestr(f"resources/{k}", b"")
    began = time.perf_counter()
    assert rules(check_fmu(file)) == {"archive"}
    assert time.perf_counter() - began < 10.0


def test_what_breaks_no_rule_is_no_fault(built: Callable, changed: Callable[..., Path]) -> None:
    """A date with underscores is a warning, as in a run; another machine's binary alone is a note."""
    path = changed("2", {DESCRIPTION: replace(r'generationDateAndTime="[^"]*"|(?=guid=)', 'generationDateAndTime="2026_11_25" ')})
    findings = check_fmu(path)
    assert rules(findings) == set()
    assert rules(findings, "warning") == {"validation"}


@pytest.mark.parametrize("exchange", [False, True], ids=["co-simulation", "model exchange"])
def test_clocks_are_ticked_when_they_are_due(exchange: bool, tmp_path: Path) -> None:
    """The FMU refuses ticks at other times, and to be asked for an interval that it does not decide on."""
    assert worse_than_notes(check_fmu(clock_fmus.clocks(tmp_path, exchange=exchange))) == []
    findings = check_fmu(clock_fmus.clocks(tmp_path, "changing", exchange=exchange))
    assert [(f.rule, f.message) for f in worse_than_notes(findings)] == [
        ("clocks", "fmi3GetIntervalDecimal failed with status 3 (error).")
    ]


@pytest.mark.parametrize("kind", ["changing", clock_fmus.FROM_PARAMETERS])
def test_values_that_an_fmu_needs_can_be_given_to_its_check(kind: str, tmp_path: Path) -> None:
    """This one has clocks of its kind where a parameter says so; intervals that follow from parameters are asked for."""
    file = clock_fmus.clocks(tmp_path, kind)
    assert worse_than_notes(check_fmu(file, values={"kind": float(clock_fmus.KINDS.index(kind))})) == []
    assert rules(check_fmu(file)) == {"clocks"}


def test_values_that_a_check_cannot_give_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="must be given start values, 'every' is the interval of a clock"):
        check_fmu(clock_fmus.clocks(tmp_path, "tunable"), values={"every": 0.2})


def test_an_fmu_that_wants_event_mode_is_tried_by_its_other_interface(tmp_path: Path) -> None:
    """FMUs with clocks of one exporter can be instantiated with event mode only."""
    assert [(f.rule, f.severity) for f in check_fmu(clock_fmus.clocks(tmp_path, events_only=True))] == [("instance", "note")]


def test_no_binary_for_this_machine_is_a_note(built: Callable, tmp_path: Path) -> None:
    other = tmp_path / "other.fmu"
    with zipfile.ZipFile(built("gain")[1]) as source, zipfile.ZipFile(other, "w") as target:
        for name in source.namelist():
            if not name.startswith("binaries/"):
                target.writestr(name, source.read(name))
    (finding,) = check_fmu(other)
    assert (finding.rule, finding.severity) == ("binary", "note")


def test_a_library_of_another_machine_is_named(changed: Callable[..., Path], tmp_path: Path) -> None:
    path = changed("2", {DESCRIPTION: lambda text: text + " "})
    other = tmp_path / "other.fmu"
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(other, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name.startswith("binaries/"):
                data = data[:18] + (183).to_bytes(2, "little") + data[20:]
            target.writestr(name, data)
    findings = check_fmu(other)
    assert rules(findings) == {"binary"}
    assert rules(findings, "warning") == {"instance"}  # the loader's own reason
