"""What --set says: values of components, and which variants take a component's place. One parser for every command.

    gyro.rotor_speed=200rpm               a value, COMPONENT.PARAMETER=VALUE
    gyro=linear                           a variant, COMPONENT=VARIANT
    gyro=linear,hil,rate_delay=5ms        several, the second with a value of its own

    rotor_speed=200rpm                    the same, where there is one component only
    gyro=vendor.fmu,torque=yaw_moment     a variant that calls the signal yaw_moment of the system torque

`run` and its kind take one variant of a component, `compare` several, the first as the reference, `sweep` all of them in turn.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..ssp.parameter_files import read_parameters
from ..systems import System
from ..systems.swap import told_apart

SWAP = "--swap must be NAME=SOURCE or NAME=SOURCE,FOREIGN=OURS,..."
VEHICLE = "vehicle"  # the component that --vehicle exchanges
_OWN = re.compile(r"[A-Za-z_][\w.\[\],]*\s*=")  # what a value of a variant begins with


@dataclass(frozen=True)
class Settings:
    """What several --set say.

    Parameters
    ----------
    values : tuple of (str, str)
        `component.parameter` and text, in the order given.
    variants : dict of str to tuple of str
        Component and its variants, each "SOURCE" or "SOURCE,PARAMETER=VALUE,...".
    """

    values: tuple[tuple[str, str], ...]
    variants: dict[str, tuple[str, ...]]


def assignment(text: str, rule: str) -> tuple[str, str]:
    """Name and value in "NAME=VALUE"; the ValueError says `rule`, such as "--where must be NAME=VALUE"."""
    name, equals, value = (word.strip() for word in text.partition("="))
    if not (name and equals):
        raise ValueError(f"{rule}, got {text!r}")
    return name, value


def words(text: str) -> list[str]:
    """The words between commas, without what is empty."""
    return [word.strip() for word in text.split(",") if word.strip()]


def read_settings(texts: Iterable[str], system: System) -> Settings:
    """What `texts`, each as after --set, say for a system; a name without a dot, or of a component, stands for a component.

    Raises
    ------
    ValueError
        Where a text has not that form, or a component gets its variants twice.
    """
    rule = "--set must be COMPONENT.PARAMETER=VALUE or COMPONENT=VARIANT"
    components = {component.name for component in system.components}
    values: list[tuple[str, str]] = []
    variants: dict[str, tuple[str, ...]] = {}
    for text in texts:
        name, value = assignment(text, rule)
        alone = len(components) == 1 and name not in components
        if alone or ("." in name and name not in components):
            values.append((system.full(name), value))
            continue
        chosen = split_variants(value)
        if not chosen:
            raise ValueError(f"{rule}, got {text!r}")
        if name in variants:
            raise ValueError(f"--set must name the variants of component {name!r} once, got it twice")
        variants[name] = chosen
    return Settings(tuple(values), variants)


def split_variants(text: str) -> tuple[str, ...]:
    """The variants in "A,B,PARAMETER=VALUE,C": a value belongs to the variant before it."""
    found: list[str] = []
    for word in words(text):
        if found and _OWN.match(word):
            found[-1] += f",{word}"
        else:
            found.append(word)
    return tuple(found)


def gyro_of(system: System) -> str:
    """What --gyro exchanges: what the system says is exchanged in it, else the component called so."""
    return "gyro" if system.exchange is None else system.exchanged()


def applied(
    system: System, gyro: str | None, texts: Sequence[str] | None, *, vehicle: str | None = None, swaps: Sequence[str] = (),
    params: Path | None = None,
) -> System:  # fmt: skip
    """The system with --vehicle, --gyro, --swap, --params and --set of a command that runs one variant of each component."""
    chosen = read_settings(texts or (), system)
    named = [(f"--vehicle is short for --swap {VEHICLE}=VARIANT", VEHICLE, vehicle)] if vehicle is not None else []
    if gyro is not None:
        name = gyro_of(system)
        named.append((f"--gyro is short for --set {name}=VARIANT", name, gyro))
    named += [("--swap names a component once", *assignment(text, SWAP)) for text in swaps]
    seen = set(chosen.variants)
    for rule, name, text in named:
        if name in seen:
            raise ValueError(f"{rule}: give one of the two, got both ({text!r})")
        seen.add(name)
        system = swapped(system, name, text)
    for name, variants in chosen.variants.items():
        if len(variants) > 1:
            raise ValueError(f"--set {name} must be one variant here (compare and sweep take several), got {', '.join(variants)}")
        source, *own = variants[0].split(",")
        renamed, values = told_apart(own, system.signals_of(name))
        system = system.with_source(name, source, renamed)
        for text in values:
            system = system.with_value(*_own(name, text))
    for target, value in read_parameters(params, system) if params is not None else ():
        system = system.with_value(target, value)
    for target, value in chosen.values:
        system = system.with_value(target, value)
    return system


def refuse_exchanged(system: System, varied: Iterable[str], exchanged: Sequence[str] | None) -> None:
    """ValueError where --model-exchange names a component whose variants are `varied`: how these run is their own matter."""
    for name in exchanged or ():
        for other in varied:
            if set(system.addressed(name)) & set(system.addressed(other)):
                raise ValueError(f"--model-exchange must name a component that stays, {name!r} is exchanged for its variants")


def swapped(system: System, name: str, text: str) -> System:
    """The system with "SOURCE,FOREIGN=OURS,..." in the place of the component(s) that `name` addresses."""
    source, *pairs = words(text)
    return system.with_source(name, source, dict(assignment(pair, SWAP) for pair in pairs))


def _own(component: str, text: str) -> tuple[str, str]:
    variable, value = assignment(text, "a variant must be SOURCE,PARAMETER=VALUE,...")
    return f"{component}.{variable}", value
