"""What the fuzzing campaign makes of good inputs: bytes turned over, structure changed, keys misspelt; by a seeded generator."""

import copy
import io
import random
import re
import warnings
import zipfile
from collections.abc import Callable

from lxml import etree

__all__ = ["Changed", "of_archive", "of_bytes", "of_table", "of_toml", "of_xml"]

Changed = tuple[bytes, bool]  # what became of it; whether a key was misspelt, which nobody may ignore

VALUES = (
    "nan", "inf", "-inf", "1e999", "-1", "0", "-0.0", "1e-320", "4294967296", "99999999999999999999", "", " ", "true", "x",
    "1 2 3", "NaN m/s", "1e308 km/h", "\u202e\u00e9\u4e2d", "a" * 3000, "../../etc/passwd", "%s%n", "[[[[", "1_000", "0x10",
    "\u0661", "\u00e9" * 300,
)  # fmt: skip

NAMES = ("../out.txt", "/etc/passwd", "a\\..\\b", "c:/x", "x" * 300, "", "con", "é\u202e")  # of members of archives
OPEN = ("CoSimulation", "ModelExchange", "ScheduledExecution")  # where FMI 3.0 lets a tool add attributes of its own


def of_bytes(data: bytes, rng: random.Random) -> Changed:
    """Bytes changed, left out, doubled, cut or exchanged, one to four times."""
    found = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        if not found:
            return b"", False
        at, n = rng.randrange(len(found)), rng.choice((1, 1, 2, 8, 64, 1000))
        match rng.randrange(6):
            case 0:
                found[at] = rng.randrange(256)
            case 1:
                del found[at : at + n]
            case 2:
                found[at:at] = found[at : at + n] * rng.choice((1, 2, 50))
            case 3:
                found[at:at] = rng.choice((b"\0", b"\xff\xfe", b"\r", b"]]>", b"<!--", b'"', b"-", b"9" * n))
            case 4:
                del found[at:]
            case _:
                other = rng.randrange(len(found))
                found[at : at + n], found[other : other + n] = found[other : other + n], found[at : at + n]
    return bytes(found), False


def of_xml(data: bytes, rng: random.Random) -> Changed:
    """An XML document with its elements and attributes changed; now and then its bytes."""
    if rng.random() < 0.2:
        return of_bytes(data, rng)
    root = etree.fromstring(data)
    misspelt = False
    rounds = rng.choice((1, 1, 1, 2, 3))
    for _ in range(rounds):
        elements = [element for element in root.iter() if isinstance(element.tag, str)]
        one = rng.choice(elements)
        names = list(one.attrib)
        match rng.randrange(10):
            case 0 if names:
                name = rng.choice(names)
                one.set(name, rng.choice(VALUES).replace("\0", ""))
            case 1 if names:
                del one.attrib[rng.choice(names)]
            case 2 if names:
                name = rng.choice(names)
                value = one.attrib.pop(name)
                one.set(_misspelt(name, rng), value)
                misspelt = misspelt or not ("}" in name or one.tag in OPEN)
            case 3:
                space, mark, local = one.tag.rpartition("}")
                one.tag = f"{space}{mark}{_misspelt(local, rng)}"
                misspelt = True
            case 4 if one is not root:
                one.getparent().remove(one)
            case 5 if one is not root:
                parent = one.getparent()
                for _ in range(rng.choice((1, 2, 30))):
                    parent.insert(rng.randrange(len(parent) + 1), copy.deepcopy(one))
            case 6 if one is not root:
                other = rng.choice(elements)
                if other is not one and one not in other.iterancestors():
                    other.append(one)
            case 7:
                other = rng.choice(elements)
                if names and other.attrib:
                    mine, theirs = rng.choice(names), rng.choice(list(other.attrib))
                    a, b = one.get(mine), other.get(theirs)
                    one.set(mine, b)
                    other.set(theirs, a)
            case 8:
                inner = one
                for _ in range(rng.choice((3, 400))):
                    inner = etree.SubElement(inner, one.tag)
            case _:
                one.text = rng.choice(VALUES)
    text = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    if rng.random() < 0.03:
        text = text.replace(b"?>", b'?><!DOCTYPE a [<!ENTITY b "c"><!ENTITY d "&b;&b;&b;">]>', 1)
    return text, misspelt and rounds == 1  # a second mistake may have taken the first away


def of_toml(data: bytes, rng: random.Random) -> Changed:
    """A TOML file with its lines changed; now and then its bytes."""
    if rng.random() < 0.2:
        return of_bytes(data, rng)
    lines = data.decode().splitlines()
    misspelt = False
    rounds = rng.choice((1, 1, 2))
    for _ in range(rounds):
        keyed = [k for k, line in enumerate(lines) if re.match(r"[\w.\"-]+\s*=", line)]
        if not keyed:
            break
        k = rng.choice(keyed)
        key, _, value = lines[k].partition("=")
        match rng.randrange(7):
            case 0:
                lines[k] = f"{key}= {_toml_value(rng)}"
            case 1:
                lines[k] = f"{_misspelt(key.strip(), rng)} ={value}"
                misspelt = True
            case 2:
                del lines[k]
            case 3:
                lines.insert(rng.randrange(len(lines)), lines[k])
            case 4:
                other = rng.choice(keyed)
                lines[other] = f"{lines[other].partition('=')[0]}={value}"
            case 5:
                lines[k] = f"{key}= {'[' * 500}"
            case _:
                lines.insert(k, f"[{'.'.join(['a'] * rng.choice((1, 3, 300)))}]")
    return "\n".join([*lines, ""]).encode("utf-8", "surrogatepass"), misspelt and rounds == 1


def of_table(data: bytes, rng: random.Random) -> Changed:
    """A .csv file with cells, rows and names changed; now and then its bytes."""
    if rng.random() < 0.3:
        return of_bytes(data, rng)
    rows = [line.split(",") for line in data.decode().splitlines()]
    for _ in range(rng.choice((1, 2, 4))):
        if not rows:
            break
        k = rng.randrange(len(rows))
        j = rng.randrange(max(1, len(rows[k])))
        match rng.randrange(6):
            case 0:
                rows[k][j : j + 1] = [rng.choice(VALUES)]
            case 1:
                rows[k].append("1")
            case 2:
                del rows[k]
            case 3:
                rows[k : k + 1] = [rows[k]] * rng.choice((2, 100))
            case 4:
                rows[0][:] = [rows[0][0]] * len(rows[0])
            case _:
                rng.shuffle(rows)
    return "\n".join(",".join(row) for row in rows).encode("utf-8", "surrogatepass"), False


def of_archive(data: bytes, rng: random.Random, inner: Callable[[bytes, random.Random], Changed] = of_xml) -> Changed:
    """A zip file with its members changed, renamed, doubled or left out, or its bytes; `inner` changes its XML."""
    if rng.random() < 0.35:
        return of_bytes(data, rng)
    misspelt = False
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = [[name, archive.read(name)] for name in archive.namelist()]
    k = rng.randrange(len(members))
    match rng.randrange(7):
        case 0:
            members[k][0] = rng.choice((*NAMES, members[0][0]))
        case 1:
            del members[k]
        case 2:
            members.append(list(members[k]))
        case 3:
            members += [[f"many/{i}", b""] for i in range(2000)]
        case 4:
            members[k][1] = b"\0" * rng.choice((0, 10, 1 << 22))
        case 5:
            members[k][1] = of_bytes(members[k][1], rng)[0]
        case _:
            documents = [one for one in members if one[0].endswith((".xml", ".ssd", ".ssv"))]
            one = rng.choice(documents or members)
            if documents:
                one[1], misspelt = inner(one[1], rng)
    target = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        warnings.simplefilter("ignore")  # names that are there twice
        for name, content in members:
            archive.writestr(zipfile.ZipInfo(name), content)
    return target.getvalue(), misspelt


def _misspelt(name: str, rng: random.Random) -> str:
    k = rng.randrange(len(name))
    return rng.choice((name[:k] + name[k] + name[k:], name[:k] + name[k + 1 :], name[:k] + "x" + name[k + 1 :])) or "x"


def _toml_value(rng: random.Random) -> str:
    bare = rng.choice(("nan", "inf", "-1", "true", "[]", "{}", "1e400", "9" * 40, "2026-01-01", "[[1], 2]", "{ a = 1 }"))
    text = rng.choice(VALUES).replace("\\", "\\\\").replace('"', "")
    return rng.choice((bare, f'"{text}"'))
