"""Who imports a name of before 0.2.0 is told its new one: `import cosim` says that it is called `gyro_cosim`.

Until 0.1 five packages of ours were installed under the names below, which others use as well. Nothing stands there any more.
The finder comes last: whatever is found under such a name, in any folder or distribution, is imported as if it did not exist.
gyro_cosim_old_names.pth beside this file loads it when Python starts, so it imports nothing of its own.
"""

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from importlib.machinery import ModuleSpec
    from types import CodeType, ModuleType

SINCE = "0.2.0"
PACKAGES = {
    "cosim": "gyro_cosim",
    "component": "gyro_cosim.component",
    "vehicle": "gyro_cosim.vehicle",
    "gyro_unit": "gyro_cosim.gyro_unit",
    "fmus": "gyro_cosim.fmus",
}
MOVED = {  # modules that are called otherwise in their package, too; what stands in a package listed here goes with it
    "component.joined": "gyro_cosim.accuracy.monolith",
    "cosim.adaptive": "gyro_cosim.master.adaptive",
    "cosim.algebraic": "gyro_cosim.network.loops",
    "cosim.archive": "gyro_cosim.systems.archive",
    "cosim.assessment": "gyro_cosim.railway.assessment",
    "cosim.bonds": "gyro_cosim.network.bonds",
    "cosim.calls": "gyro_cosim.kernel.ctypes_calls",
    "cosim.catalogue": "gyro_cosim.systems.catalogue",
    "cosim.certificate": "gyro_cosim.accuracy.certificate",
    "cosim.check.bench": "gyro_cosim.check.examined",
    "cosim.check.subject": "gyro_cosim.check.instance",
    "cosim.checkpoint": "gyro_cosim.master.checkpoint",
    "cosim.comfort": "gyro_cosim.railway.comfort",
    "cosim.compare": "gyro_cosim.comparison.candidates",
    "cosim.compensation": "gyro_cosim.hil.compensation",
    "cosim.convergence": "gyro_cosim.accuracy.convergence",
    "cosim.dataflow": "gyro_cosim.network.loops",
    "cosim.delay": "gyro_cosim.hil.delay_margin",
    "cosim.difference": "gyro_cosim.comparison.difference",
    "cosim.energy": "gyro_cosim.master.energy",
    "cosim.evaluation": "gyro_cosim.network.evaluation",
    "cosim.fast": "gyro_cosim.kernel.driver",
    "cosim.linear": "gyro_cosim.network.linearised",
    "cosim.loop": "gyro_cosim.kernel.loop",
    "cosim.loop_numba": "gyro_cosim.kernel.native",
    "cosim.march": "gyro_cosim.master.stepping",
    "cosim.monolith": "gyro_cosim.accuracy.monolith",
    "cosim.packing": "gyro_cosim.ssp.packing",
    "cosim.paper.chance": "gyro_cosim.paper.sensitivity.statistics",
    "cosim.paper.draws": "gyro_cosim.paper.sensitivity.draws",
    "cosim.paper.open_parameters": "gyro_cosim.paper.sensitivity.open_parameters",
    "cosim.paper.pair_draws": "gyro_cosim.paper.sensitivity.pair_draws",
    "cosim.paper.sensitivity_figures": "gyro_cosim.paper.sensitivity.figures",
    "cosim.paper.sensitivity_page": "gyro_cosim.paper.sensitivity.page",
    "cosim.paper.studied": "gyro_cosim.paper.sensitivity.study",
    "cosim.paper.vehicle_draws": "gyro_cosim.paper.sensitivity.vehicle_draws",
    "cosim.quantities": "gyro_cosim.systems.quantities",
    "cosim.realtime": "gyro_cosim.hil.realtime",
    "cosim.recording": "gyro_cosim.master.recording",
    "cosim.report": "gyro_cosim.paper.ledger",
    "cosim.response": "gyro_cosim.comparison.frequency_response",
    "cosim.safety": "gyro_cosim.railway.safety",
    "cosim.sampled": "gyro_cosim.hil.sampled_model",
    "cosim.slaves.asking": "gyro_cosim.slaves.fmi.intermediate_update",
    "cosim.slaves.child": "gyro_cosim.slaves.processes.child",
    "cosim.slaves.description": "gyro_cosim.slaves.fmi.description",
    "cosim.slaves.events": "gyro_cosim.slaves.fmi.events",
    "cosim.slaves.fmi2": "gyro_cosim.slaves.fmi.fmi2",
    "cosim.slaves.fmi3": "gyro_cosim.slaves.fmi.fmi3",
    "cosim.slaves.fmu": "gyro_cosim.slaves.fmi.fmu",
    "cosim.slaves.groups": "gyro_cosim.slaves.fmi.buffers",
    "cosim.slaves.interface": "gyro_cosim.hil.delayed_slave",
    "cosim.slaves.isolated": "gyro_cosim.slaves.processes.isolated",
    "cosim.slaves.library": "gyro_cosim.slaves.fmi.library",
    "cosim.slaves.opened": "gyro_cosim.slaves.fmi.unpacked",
    "cosim.slaves.remote": "gyro_cosim.slaves.processes.remote",
    "cosim.slaves.serving": "gyro_cosim.slaves.processes.serving",
    "cosim.slaves.states": "gyro_cosim.slaves.fmi.fmu_state",
    "cosim.slaves.variables": "gyro_cosim.slaves.fmi.signals",
    "cosim.slaves.wire": "gyro_cosim.slaves.processes.protocol",
    "cosim.ssd": "gyro_cosim.ssp",
    "cosim.ssd.structure": "gyro_cosim.ssp.reading",
    "cosim.studies": "gyro_cosim.stability",
    "cosim.studies.optimum": "gyro_cosim.stability.optimisation",
    "cosim.studies.paths": "gyro_cosim.stability.root_paths",
    "cosim.studies.rest": "gyro_cosim.stability.at_rest",
    "cosim.studies.signals": "gyro_cosim.stability.root_paths",
    "cosim.sweep": "gyro_cosim.sweeps",
    "cosim.sweep.inquiry": "gyro_cosim.sweeps.query",
    "cosim.system": "gyro_cosim.systems",
    "cosim.tolerance": "gyro_cosim.comparison.tolerances",
    "cosim.unit_energy": "gyro_cosim.comparison.unit_energy",
    "cosim.unit_figures": "gyro_cosim.comparison.figures",
    "cosim.wiring": "gyro_cosim.network.wiring",
}


def successor(name: str) -> str:
    """What the module `name` of before 0.2.0 is called now."""
    known, rest = name, ""
    while known not in MOVED and known not in PACKAGES:
        known, _, leaf = known.rpartition(".")
        rest = f".{leaf}{rest}"
    return (MOVED.get(known) or PACKAGES[known]) + rest


def message(name: str) -> str:
    """The one line that an import of `name` ends with."""
    example = " (from gyro_cosim import simulate)" if name == "cosim" else ""
    return f"No module named {name!r}: it is called {successor(name)!r} since {SINCE}{example}"


def wanted(name: str) -> str:
    """The module whose import led to that of `name`: for `import cosim.studies` Python looks for `cosim` first."""
    frame = sys._getframe()
    while frame.f_back is not None:
        frame = frame.f_back
        outer = frame.f_locals.get("name") if frame.f_code.co_filename == "<frozen importlib._bootstrap>" else None
        if isinstance(outer, str) and outer.startswith(f"{name}."):
            name = outer
    return name


class OldName:
    """Finder and loader of the old names: it finds them last and loads none."""

    @staticmethod
    def find_spec(name: str, path: "Sequence[str] | None" = None, target: "ModuleType | None" = None) -> "ModuleSpec | None":
        """Where an old name is found, when nobody else has it: finders that came after this one are asked first, too."""
        if name not in PACKAGES:
            return None
        later = sys.meta_path[sys.meta_path.index(OldName) + 1 :]
        if any(finder.find_spec(name, path, target) is not None for finder in later):
            return None
        from importlib.machinery import ModuleSpec

        return ModuleSpec(name, OldName)  # type: ignore[arg-type]

    @staticmethod
    def create_module(spec: "ModuleSpec") -> "ModuleType":
        """Refuse `import cosim`."""
        raise ModuleNotFoundError(message(wanted(spec.name)), name=spec.name)

    @staticmethod
    def exec_module(module: "ModuleType") -> None:
        """Nothing: no module is ever made."""

    @staticmethod
    def get_code(name: str) -> "CodeType":
        """Refuse `python -m cosim`."""
        raise ModuleNotFoundError(message(name), name=name)


if OldName not in sys.meta_path:
    sys.meta_path.append(OldName)
