"""What the documents of SSP 1.0 and 2.0 may hold, element by element, and a check that names line and nearest name.

The table states the facts of the standard's schemas: attributes with their types ("!": must be there), children ("!": must
be there, "*": any number). Where a document of 1.0 uses what only 2.0 has, it means the same, so one table serves both.
Neither the order of children nor a list given in two parts changes what is meant, and neither is refused. Attributes of
other namespaces belong to other tools.
"""

import re
from collections.abc import Mapping
from functools import cache

from lxml import etree

from ..errors import unknown

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssm": "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
    "ssb": "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary",
    "gc": "urn:gyro-cosim:1",
}
ANNOTATION = "gyro-cosim"
REAL = ("Real", "Float64", "Float32")
TYPES = (
    *REAL, "Integer", *(f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")),
    "Boolean", "String", "Enumeration", "Binary", "Clock",
)  # fmt: skip

_BASE = "id description"
_TOP = f"{_BASE} version author fileversion copyright license generationTool generationDateAndTime"
_CHOICE = " ".join(f"ssc:{name}" for name in TYPES)
_WAY = "ssc:LinearTransformation ssc:BooleanMappingTransformation ssc:IntegerMappingTransformation " + (
    "ssc:EnumerationMappingTransformation"
)
_META = "ssc:MetaData* ssc:Signature*"
_PLACE = "source sourceBase=SSD|component type"
_PART = f"ssd:Connectors ssd:ElementGeometry ssd:ParameterBindings {_META} ssd:Annotations"
_BOX = "x1=double! y1=double! x2=double! y2=double!"
_CLOCK = (
    "intervalVariability=constant|fixed|tunable|changing|countdown|triggered intervalDecimal=double shiftDecimal=double "
    "supportsFraction=boolean resolution=int intervalCounter=int shiftCounter=int priority=int"
)
_KINDS = "input|output|parameter|calculatedParameter|structuralParameter|constant|local|inout|unspecified"

# element: attributes > children; "PARENT/element" where the name means something else elsewhere.
_TABLE = f"""
ssd:SystemStructureDescription: name {_TOP} > ssd:System! ssd:Enumerations ssd:Units ssd:DefaultExperiment {_META} ssd:Annotations
ssd:System: name! {_BASE} > {_PART} ssd:Elements ssd:Connections ssd:SignalDictionaries ssd:SystemGeometry ssd:GraphicalElements
ssd:Component: name! {_BASE} type source implementation=any|ModelExchange|CoSimulation|ScheduledExecution > {_PART}
ssd:SignalDictionaryReference: name! {_BASE} dictionary! > {_PART}
ssd:Elements: > ssd:Component* ssd:System* ssd:SignalDictionaryReference*
ssd:Connectors: > ssd:Connector*
ssd:Connector: name! {_BASE} kind={_KINDS}! > {_CHOICE} ssc:Dimension* ssd:Clock* ssd:ConnectorGeometry ssd:Annotations
ssd:Clock: name! >
ssd:Connections: > ssd:Connection*
ssd:Connection: {_BASE} startElement startConnector! startIndices endElement endConnector! endIndices \
suppressUnitConversion=boolean > {_WAY} ssd:ConnectionGeometry ssd:Annotations
ssd:ParameterBindings: > ssd:ParameterBinding*
ssd:ParameterBinding: {_BASE} {_PLACE} prefix > ssd:ParameterValues ssd:ParameterMapping {_META} ssd:Annotations
ssd:ParameterValues: > ssv:ParameterSet*
ssd:ParameterMapping: {_BASE} {_PLACE} > ssm:ParameterMapping
ssd:SignalDictionaries: > ssd:SignalDictionary*
ssd:SignalDictionary: name! {_BASE} type source > ssb:SignalDictionary
ssd:ElementGeometry: {_BOX} rotation=double iconSource iconRotation=double iconFlip=boolean iconFixedAspectRatio=boolean >
ssd:ConnectorGeometry: x=double! y=double! systemInnerX=double systemInnerY=double >
ssd:ConnectionGeometry: pointsX! pointsY! >
ssd:SystemGeometry: {_BOX} >
ssd:GraphicalElements: > ssd:Note*
ssd:Note: {_BOX} text! >
ssd:Enumerations: > ssc:Enumeration*
ssd:Units: > ssc:Unit*
ssd:DefaultExperiment: startTime=double stopTime=double > ssd:Annotations
ssd:Annotations: > ssc:Annotation*
ssc:Annotations: > ssc:Annotation*
ssc:Enumeration: name {_BASE} > ssc:Item* ssc:Annotations
ssc:Item: name! value=int! >
ssc:Unit: name! {_BASE} > ssc:BaseUnit ssc:Annotations
ssc:BaseUnit: kg=int m=int s=int A=int K=int mol=int cd=int rad=int factor=double offset=double >
ssc:Dimension: size=int sizeConnector >
ssc:Clock: {_CLOCK} >
ssc:Binary: mime-type >
ssc:LinearTransformation: factor=double offset=double >
ssc:BooleanMappingTransformation: > ssc:MapEntry*
ssc:IntegerMappingTransformation: > ssc:MapEntry*
ssc:EnumerationMappingTransformation: > ssc:MapEntry*
ssc:BooleanMappingTransformation/ssc:MapEntry: source=boolean! target=boolean! >
ssc:IntegerMappingTransformation/ssc:MapEntry: source=int! target=int! >
ssc:EnumerationMappingTransformation/ssc:MapEntry: source! target! >
ssc:MetaData: {_BASE} kind! type! source sourceBase=file|resource > ssc:Content ssc:Signature*
ssc:Signature: {_BASE} role! type! source sourceBase=file|resource|metaData > ssc:Content
ssv:ParameterSet: name {_TOP} > ssv:Parameters! ssv:Enumerations ssv:Units {_META} ssv:Annotations
ssv:Parameters: > ssv:Parameter*
ssv:Parameter: name! {_BASE} > {_CHOICE.replace("ssc", "ssv")} ssc:Dimension* ssv:Annotations
ssv:String: value > ssv:Value*
ssv:Enumeration: value name > ssv:Value*
ssv:Binary: value mime-type > ssv:Value*
ssv:Value: value! >
ssv:Boolean: value! >
ssv:Enumerations: > ssc:Enumeration*
ssv:Units: > ssc:Unit*
ssv:Annotations: > ssc:Annotation*
ssm:ParameterMapping: {_TOP} > ssm:MappingEntry* {_META} ssm:Annotations
ssm:MappingEntry: {_BASE} source! target! suppressUnitConversion=boolean > {_WAY} ssm:Annotations
ssm:Annotations: > ssc:Annotation*
ssb:SignalDictionary: name {_TOP} > ssb:DictionaryEntry* ssb:Enumerations ssb:Units {_META} ssb:Annotations
ssb:DictionaryEntry: name! {_BASE} > {_CHOICE} ssc:Dimension* ssb:Annotations
ssb:Enumerations: > ssc:Enumeration*
ssb:Units: > ssc:Unit*
ssb:Annotations: > ssc:Annotation*
gc:Master: step=double >
gc:Bond: motion! effort! >
gc:StopWhen: signal! above=double says >
gc:Exchange: component! ending >
"""
_FREE = ("ssc:Content",)  # whatever its type says
_PATTERNS = {
    "double": (re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"), "a number"),
    "int": (re.compile(r"[-+]?\d+"), "a whole number"),
    "boolean": (re.compile("true|false|1|0"), "true, false, 1 or 0"),
}


class RuleError(ValueError):
    """What a document must not hold; `element` says where."""

    def __init__(self, element: etree._Element, why: str) -> None:
        super().__init__(why)
        self.element = element


@cache
def _rules() -> dict[str, tuple[dict[str, str], dict[str, str]]]:
    """Element -> its attributes and children, each with what stands behind the name."""
    found = {}
    for line in filter(None, _TABLE.split("\n")):
        name, rest = line.split(": ", 1) if ": " in line else (line.partition(":>")[0], "")
        attributes, _, children = rest.partition(">")
        found[name] = (_words(attributes, r"([^=!]+)(.*)"), _words(children, r"([^*!]+)(.*)"))
    for kind, more in (("ssc", ""), ("ssv", "value!")):
        for of in TYPES:
            unit = " unit" if of in REAL else ""
            found.setdefault(f"{kind}:{of}", (dict.fromkeys(unit.split(), "") | ({"value": "!"} if more else {}), {}))
    return found


def _words(text: str, pattern: str) -> dict[str, str]:
    found = (re.fullmatch(pattern, word) for word in text.split())
    return {match[1]: match[2] for match in found if match is not None}


def check(root: etree._Element) -> None:
    """RuleError at the first place where `root` and what it holds break the table.

    What stands in another tool's annotation is not looked at.
    """
    pending = [root]
    while pending:
        element = pending.pop()
        _check(element)
        name = short(element)
        if name not in _FREE and (name != "ssc:Annotation" or element.get("type") == ANNOTATION):
            pending += [child for child in reversed(element) if isinstance(child.tag, str)]


def short(element: etree._Element) -> str:
    """The name of an element with the usual prefix of its namespace: "ssd:System"; empty for other namespaces."""
    return _short(str(element.tag))


@cache
def _short(tag: str) -> str:
    name = etree.QName(tag)
    prefix = next((kind for kind, space in NAMESPACES.items() if space == name.namespace), "")
    return f"{prefix}:{name.localname}" if prefix else ""


def _check(element: etree._Element) -> None:
    name = short(element)
    if name == "ssc:Annotation":
        _annotation(element)
        return
    rule = _rules().get(name) or _rules().get(f"{short(element.getparent())}/{name}")  # the latter is an entry of a mapping
    if rule is None or name in _FREE:
        return  # a child that its parent has let in
    attributes, children = rule
    _attributes(element, attributes)
    _children(element, children)
    if (element.text or "").strip():
        raise RuleError(element, f"must hold no text, got {' '.join((element.text or '').split())[:40]!r}")


def _attributes(element: etree._Element, known: Mapping[str, str]) -> None:
    for name, text in element.attrib.items():
        if str(name).startswith("{"):
            continue
        if name not in known:
            raise RuleError(element, str(unknown("attribute", str(name), known)))
        allowed = known[str(name)].strip("=!")
        pattern, words = _PATTERNS.get(allowed, (None, ""))
        if pattern is not None and not pattern.fullmatch(str(text).strip()):
            raise RuleError(element, f"{name} must be {words}, got {str(text)!r}")
        if pattern is None and allowed and text not in allowed.split("|"):
            raise RuleError(element, f"{name} must be one of {', '.join(allowed.split('|'))}, got {str(text)!r}")
    for name, rest in known.items():
        if rest.endswith("!") and name not in element.attrib:
            raise RuleError(element, f"must have the attribute {name!r}")


def _children(element: etree._Element, known: Mapping[str, str]) -> None:
    seen = set()
    for child in element:
        if not isinstance(child.tag, str):
            continue
        name = short(child)
        if name not in known:
            local = etree.QName(child).localname
            right = next((k for k in known if k.partition(":")[2] == local), "")
            if right:
                space = NAMESPACES[right.partition(":")[0]]
                raise RuleError(child, f"must be of the namespace {space}, is of {etree.QName(child).namespace or 'none'}")
            where = f"element of {etree.QName(element).localname}"
            raise RuleError(child, str(unknown(where, local, [k.partition(":")[2] for k in known])))
        if name in seen and "*" not in known[name] and not name.endswith("s"):
            raise RuleError(child, f"must stand once in {etree.QName(element).localname}, this is the second")
        seen.add(name)
    for name, rest in known.items():
        if "!" in rest and name not in seen:
            raise RuleError(element, f"must hold a {name.partition(':')[2]}")


def _annotation(element: etree._Element) -> None:
    """Our annotations hold our elements and nothing else; those of other tools hold what they like, but not ours."""
    if "type" not in element.attrib:
        raise RuleError(element, "must have the attribute 'type'")
    ours = element.get("type") == ANNOTATION
    for child in element:
        if isinstance(child.tag, str) and ours != (etree.QName(child).namespace == NAMESPACES["gc"]):
            space = NAMESPACES["gc"]
            why = f"an annotation of type {ANNOTATION!r} must hold elements of the namespace {space}, and no other may"
            raise RuleError(child, f"{why}; its type is {element.get('type')!r}")
        if ours and isinstance(child.tag, str) and short(child) not in _rules():
            known = [k.partition(":")[2] for k in _rules() if k.startswith("gc:")]
            raise RuleError(child, str(unknown("element of the annotation", etree.QName(child).localname, known)))
