"""The icon of an FMU: a block with an arrow for every input and output. Drawn here, the same bytes every time."""

import struct
import zlib
from xml.sax.saxutils import escape

import numpy as np

from gyro_cosim.component import Component

__all__ = ["SIZE", "png", "svg"]

SIZE = 200  # pixels each way
INK, PAPER, FILL = (31, 61, 92), (255, 255, 255), (226, 236, 246)
LEFT, RIGHT, TOP, BOTTOM = 40, 160, 20, 180
ARROW = 12  # pixels from base to tip


def _heights(n: int) -> list[float]:
    """Where `n` arrows meet the block's side."""
    return [TOP + (BOTTOM - TOP) * (i + 1) / (n + 1) for i in range(n)]


def png(component: Component) -> bytes:
    """The icon as a PNG file of SIZE x SIZE pixels."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] + 0.5
    image = np.empty((SIZE, SIZE, 3), np.uint8)
    image[:] = PAPER
    image[(x > LEFT) & (x < RIGHT) & (y > TOP) & (y < BOTTOM)] = INK
    image[(x > LEFT + 3) & (x < RIGHT - 3) & (y > TOP + 3) & (y < BOTTOM - 3)] = FILL
    circle = np.hypot(x - SIZE / 2, y - SIZE / 2)
    image[(circle < 34) & (circle > 30)] = INK  # a rotor, seen along its axis
    image[circle < 6] = INK
    for tip, n in ((LEFT - 4, len(component.inputs)), (SIZE - 6, len(component.outputs))):
        for height in _heights(n):
            half = min(7.0, 60.0 / max(n, 1))
            image[(x < tip) & (x > tip - ARROW) & (abs(y - height) < half * (tip - x) / ARROW)] = INK
            image[(x > tip - 32) & (x <= tip - ARROW) & (abs(y - height) < 1.5)] = INK
    rows = b"".join(b"\0" + image[i].tobytes() for i in range(SIZE))
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(rows, 9)) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def svg(component: Component) -> bytes:
    """The same icon as an SVG file, with the component's name on it."""

    def colour(rgb: tuple[int, int, int]) -> str:
        return "#" + bytes(rgb).hex()

    shapes = [
        f'<rect x="{LEFT}" y="{TOP}" width="{RIGHT - LEFT}" height="{BOTTOM - TOP}" fill="{colour(FILL)}" '
        f'stroke="{colour(INK)}" stroke-width="3"/>',
        f'<circle cx="100" cy="100" r="32" fill="none" stroke="{colour(INK)}" stroke-width="4"/>',
        f'<circle cx="100" cy="100" r="6" fill="{colour(INK)}"/>',
    ]
    for tip, n in ((LEFT - 4, len(component.inputs)), (SIZE - 6, len(component.outputs))):
        for h in _heights(n):
            half = min(7.0, 60.0 / n)
            points = f"{tip},{h:.2f} {tip - ARROW},{h - half:.2f} {tip - ARROW},{h + half:.2f}"
            line = f'x1="{tip - 32}" y1="{h:.2f}" x2="{tip - ARROW}" y2="{h:.2f}"'
            shapes += [
                f'<polygon points="{points}" fill="{colour(INK)}"/>',
                f'<line {line} stroke="{colour(INK)}" stroke-width="3"/>',
            ]
    for line_text, y in ((component.name, 48), (component.variant, 164)):
        style = f'font-family="sans-serif" font-size="13" text-anchor="middle" fill="{colour(INK)}"'
        shapes.append(f'<text x="100" y="{y}" {style}>{escape(line_text)}</text>')
    body = "\n  ".join(shapes)
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE} {SIZE}">\n  {body}\n</svg>\n'.encode()
