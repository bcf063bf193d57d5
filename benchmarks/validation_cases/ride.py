"""Ride on a random track: a run in time against the transfer function of the linearised vehicle, on the same record."""

import tempfile
from pathlib import Path

import numpy as np

from gyro_cosim.stability.response import Wave, wave_response
from gyro_cosim.systems import System, SystemComponent, catalogue
from gyro_cosim.vehicle.spectra import random_record

from .table import Line, Quantity, Table

__all__ = ["on_random_track"]

SPEED, LENGTH, FADE, AHEAD = 10.0, 150.0, 20.0, 10.0  # m/s, m, m, m of even track first
H = 1e-3  # s
BAND = (0.3, 20.0)  # Hz
FILE = """
[vehicle]
extends = "vehicle:lrt_solid_axle"
name = "ride"
speed = "10 m/s"
[track]
irregularity = "record.csv"
fade = "20 m"
"""
STATES = ("body_vertical_velocity", "body_pitch_rate", "front_vertical_velocity")


def _run(file: Path) -> np.ndarray:
    """The states over time, shape (steps, n); by the component's own steps, nothing else."""
    c = catalogue.component(str(file))
    x, p = c.start_state, c.start_parameters
    u = np.zeros((len(c.inputs), 3))
    rows = [x]
    for _ in range(int((LENGTH + 2 * AHEAD) / SPEED / H)):
        x = np.array(c.step(x, u, p, 0.0, H)).ravel()
        rows.append(x)
    names = [v.name for v in c.states]
    return np.array(rows)[:, [names.index(state) for state in STATES]]


def on_random_track() -> Table:
    """Rms of rates of change in a band, and how far the histories are apart."""
    with tempfile.TemporaryDirectory() as folder:
        place, found = random_record("low", 7, LENGTH)
        text = "\n".join(f"{AHEAD + s},{z}" for s, z in zip(place, found["vertical"], strict=True))
        (Path(folder) / "record.csv").write_text("distance [m],vertical [m]\n" + text, encoding="utf-8")
        (Path(folder) / "ride.toml").write_text(FILE, encoding="utf-8")
        file = Path(folder) / "ride.toml"
        ours = _run(file)
        system = System("ride", (SystemComponent("vehicle", "vehicle:lrt_solid_axle"),), ()).with_value("vehicle.speed", SPEED)
        n = ours.shape[0] - 1
        f = np.fft.rfftfreq(n, H)
        inside = (f >= BAND[0]) & (f <= BAND[1])
        u = np.clip(np.minimum(place, place[-1] - place) / FADE, 0.0, 1.0)
        faded = found["vertical"] * u * u * (3 - 2 * u)
        track = np.fft.rfft(_between(AHEAD + place, faded, SPEED * H * np.arange(n)))
        keys = (
            f"vehicle.{key}" for key in ("stretch_vertical", "stretch_wavelength", "stretch_start", "stretch_cycles", "speed")
        )
        response = wave_response(system, Wave(*keys), f[inside].tolist(), ("vehicle.*distance",)).states
    lines = []
    for k, state in enumerate(STATES):
        spectrum = np.zeros(f.size, complex)
        # a wave a sin(k s) is the imaginary part of a exp(i k s): a record's own components are met alike
        spectrum[inside] = response[f"vehicle.{state}"] * track[inside]
        theirs = np.fft.irfft(2j * np.pi * f * spectrum, n)
        own = np.fft.rfft(ours[:-1, k])
        own[~inside] = 0.0
        run = np.fft.irfft(2j * np.pi * f * own, n)
        apart = float(np.sqrt(np.mean((run - theirs) ** 2)) / np.sqrt(np.mean(theirs**2)))
        pair = (float(np.sqrt(np.mean(run**2))), float(np.sqrt(np.mean(theirs**2))))
        unit = "rad/s2" if state.endswith("rate") else "m/s2"
        lines.append(Line(f"rate of `{state}`, {unit}", (pair, (100 * apart, 0.0))))
    source = "transfer function of the linearised vehicle (`cosim response`), times the same record"
    quantities = (Quantity("rms", ".3g", 0.01, relative=True), Quantity("histories apart, % of it", ".1f", 2.0))
    return Table(source, quantities, tuple(lines))


def _between(place: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The cubic spline that the vehicle runs on."""
    from scipy.interpolate import CubicSpline

    found: np.ndarray = CubicSpline(place, values)(np.clip(at, place[0], place[-1]))
    return found
