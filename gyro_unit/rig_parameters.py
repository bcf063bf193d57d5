"""The test rig around a gyro unit: table, sensors, transport. 0 turns an effect off; with all off the rig is the bare gyro unit.

Every number is assumed: RIG_SMALL a table-top rig for the 1/10-scale gyro unit, RIG_FULL a machine-hall one for the
full-scale gyro unit. Replace them by the data sheets of your own. Signals are in SI: a 16-bit rate sensor of +-300 deg/s has
steps of 1.6e-4 rad/s.
"""

from gyro_cosim.component import Variable, parameter

from .noise import MAX_SEED

__all__ = ["MAX_BANDWIDTH", "OFF", "RIG_FULL", "RIG_SMALL", "sensor"]

_ASSUMED = "assumed, see gyro_unit/rig_parameters.py"
MAX_BANDWIDTH = 200.0  # Hz; a first-order lag of it is resolved by an internal step of 1 ms


def _limit(name: str, start: float, unit: str, meaning: str, max: float | None = None) -> Variable:
    """A parameter that is 0 (off) or positive."""
    return parameter(name, start, unit, f"{meaning}; 0: off", source=_ASSUMED, min=0.0, max=max,
                     assumed=(0.0, max if max is not None else 10 * start))  # fmt: skip


def sensor(
    way: str, unit: str, *, bandwidth: float, bias: float, noise: float, quantisation: float, period: float, delay: float
) -> tuple[Variable, ...]:
    """Make the parameters of the sensor and the transport of one way.

    Parameters
    ----------
    way : str
        "rate" (towards the gyro unit) or "moment" (back).
    unit : str
        Of what is measured.
    bandwidth, bias, noise, quantisation, period, delay : float
        Hz; bias, standard deviation of the noise and step of the numbers in `unit`; sampling period and delay in s. 0: off.

    Returns
    -------
    tuple of Variable
        Rows for the table of a rig.
    """
    return (
        _limit(f"{way}_bandwidth", bandwidth, "Hz", f"bandwidth of the {way} sensor, first order", MAX_BANDWIDTH),
        parameter(f"{way}_bias", bias, unit, f"bias of the {way} sensor, about every axis", source=_ASSUMED,
                  assumed=(-10 * bias, 10 * bias)),
        _limit(f"{way}_noise", noise, unit, f"standard deviation of the {way} sensor's noise, white over the samples"),
        _limit(f"{way}_quantisation", quantisation, unit, f"step of the {way} sensor's numbers"),
        _limit(f"{way}_sampling_period", period, "s", f"sampling period of the {way} sensor, held in between", 1.0),
        parameter(f"{way}_delay", delay, "s", f"transport delay of the {way}; between ticks it is interpolated", source=_ASSUMED,
                  assumed=(0.0, 1.0), min=0.0),
    )  # fmt: skip


def _rig(
    rate: tuple[Variable, ...], moment: tuple[Variable, ...], *, bandwidth: float, rate_limit: float, acceleration: float
) -> tuple[Variable, ...]:
    return (
        _limit("table_bandwidth", bandwidth, "Hz", "bandwidth of the yaw table, first order", MAX_BANDWIDTH / 2),
        _limit("table_rate_limit", rate_limit, "rad/s", "largest rate of the yaw table"),
        _limit("table_acceleration_limit", acceleration, "rad/s2", "largest acceleration of the yaw table"),
        parameter("table_tilts", 1.0, "1", "1: the rig imposes roll and pitch too, ideally; 0: yaw only", source=_ASSUMED,
                  assumed=(0.0, 1.0), min=0.0, max=1.0),
        *rate,
        *moment,
        parameter("dropout_rate", 1e-3, "1", "share of samples that is lost each way; the last one that came is held; 0: off",
                  source=_ASSUMED, assumed=(0.0, 0.1), min=0.0, max=1.0),
        parameter("seed", 1.0, "1", "whole number that decides noise and drop-outs", source="free", min=0.0, max=MAX_SEED),
    )  # fmt: skip


RIG_SMALL = _rig(
    sensor("rate", "rad/s", bandwidth=100.0, bias=1e-3, noise=1e-3, quantisation=2e-4, period=1e-3, delay=1e-3),
    sensor("moment", "N.m", bandwidth=100.0, bias=1e-5, noise=2e-5, quantisation=5e-6, period=1e-3, delay=1e-3),
    bandwidth=30.0, rate_limit=5.0, acceleration=200.0,
)  # fmt: skip
RIG_FULL = _rig(
    sensor("rate", "rad/s", bandwidth=100.0, bias=2e-4, noise=2e-4, quantisation=5e-5, period=1e-3, delay=1e-3),
    sensor("moment", "N.m", bandwidth=100.0, bias=1.0, noise=1.0, quantisation=0.5, period=1e-3, delay=1e-3),
    bandwidth=15.0, rate_limit=1.0, acceleration=20.0,
)  # fmt: skip
OFF = {v.name: 0.0 for v in RIG_SMALL if v.name not in ("table_tilts", "seed")}
