"""What other tools write into the annotations of a system file: their macro step is taken, the rest is told."""

from math import isfinite

from lxml import etree

from .documents import Document
from .rules import ANNOTATION, NAMESPACES

USUAL = 1e-3  # s, where nobody states a step
# Element -> attribute that holds the step of a master: OMSimulator; libcosim, Vico and Ecos; fmigo.
_STEPS = {
    "FixedStepMaster": ("stepSize", "baseStepSize"),
    "FixedStepAlgorithm": ("baseStepSize",),
    "MasterArguments": ("timestep",),
}
_SOLVERS = ("VariableStepSolver", "VariableStepMaster")


def macro_step(found: Document) -> float:
    """The usual macro step (s) of a system file; what its annotations say and is not followed goes into the notes.

    Ours goes first; then another tool's, the outermost where several state one; else 1 ms.
    """
    ours = found.root.find(f".//ssc:Annotation[@type='{ANNOTATION}']//gc:Master", NAMESPACES)
    step, used = None, set()
    if ours is not None:
        step = _positive(found, ours, "step", f"{USUAL!r}")
    places = sorted(_foreign(found.root), key=lambda place: place[0])
    for _, kind, element in places:
        name = etree.QName(element).localname
        attribute = next((a for a in _STEPS.get(name, ()) if a in element.attrib), "")
        if attribute:
            used.add(kind)
            stated = _positive(found, element, attribute)
            if step is None:
                step = stated
                found.note(element, f"macro step {step:g} s as {kind} states it ({name} {attribute})")
            elif stated != step:
                found.note(element, f"{kind} states a step of {stated:g} s, which is not followed")
        elif name in _SOLVERS:
            used.add(kind)
            span = f" with steps of {element.get('minimumStepSize')} to {element.get('maximumStepSize')} s"
            what = f"{kind} asks for {name} {element.get('description', '')}{span if 'maximumStepSize' in element.attrib else ''}"
            found.note(element, f"{what}, which is not followed: the components keep to the macro step")
    others = sorted({kind for _, kind, _ in places} - used)
    if others:
        found.note(found.root, f"annotations of other tools are not read: {', '.join(others)}")
    return USUAL if step is None else step


def _foreign(root: etree._Element) -> list[tuple[int, str, etree._Element]]:
    """Depth, type of annotation and element of all that other tools' annotations hold."""
    places = []
    for annotation in root.iter(f"{{{NAMESPACES['ssc']}}}Annotation"):
        kind = annotation.get("type", "")
        if kind != ANNOTATION:
            depth = sum(1 for _ in annotation.iterancestors())
            places += [(depth, kind, e) for e in annotation.iterdescendants() if isinstance(e.tag, str)]
    return places


def _positive(found: Document, element: etree._Element, name: str, default: str = "") -> float:
    step = found.number(element, name, default)
    if not (isfinite(step) and step > 0.0):
        raise found.fault(element, f"{name} must be positive, got {element.get(name)!r}")
    return step
