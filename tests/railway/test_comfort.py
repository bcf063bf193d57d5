"""Ride comfort: weighting filters against published values, N_MV of signals whose value is known."""

import numpy as np
import pytest

from gyro_cosim.railway.comfort import W_B, W_B_ISO_8041, W_D, Weighting, mean_comfort, percentile, verdict, weighted, window_rms

# ISO 2631-1:1997, Table 3, W_d times 1000, at the third octaves' nominal frequencies from 0.1 Hz on. At 10 Hz
# 212 is printed; the standard's own formula gives 201.7, as its neighbours do, so that is taken for a misprint and left out.
TABLE_3 = (
    "62.4", "97.3", "158", "243", "365", "530", "713", "853", "944", "992",
    "1011", "1008", "968", "890", "776", "642", "512", "409", "323", "253",
    "-", "161", "125", "100", "80.0", "63.2", "49.4", "38.8", "29.5", "21.1",
    "14.1", "8.63", "4.55", "2.43", "1.26", "0.64", "0.31",
)  # fmt: skip
NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)  # times powers of 10
T = np.arange(0.0, 80.0, 1e-3)  # s


@pytest.mark.parametrize("band", [k for k, factor in enumerate(TABLE_3) if factor != "-"])
def test_w_d_is_the_table_of_iso_2631(band: int) -> None:
    f = NOMINAL[band % 10] * 10.0 ** (band // 10 - 1)
    half_a_digit = 0.5 * 10.0 ** -len(TABLE_3[band].partition(".")[2])
    assert abs(W_D.response(np.array(f))) * 1000 == pytest.approx(float(TABLE_3[band]), abs=half_a_digit)


@pytest.mark.parametrize(("weighting", "published"), [(W_D, 0.1261), (W_B_ISO_8041, 0.8126)], ids=["W_d", "W_b"])
def test_weights_at_iso_8041s_reference_frequency(weighting: Weighting, published: float) -> None:
    # four digits are published; K = 0.4 stands for 1.024 (2.5 / 4)^2 exactly
    assert abs(weighting.response(np.array(100 / (2 * np.pi)))) == pytest.approx(published, abs=5e-5)


def test_en_12299s_w_b_stays_near_that_of_iso_8041() -> None:
    f = np.geomspace(0.1, 100.0, 200)
    ratio = abs(W_B.response(f)) / abs(W_B_ISO_8041.response(f))
    assert 0.92 < ratio.min() < ratio.max() < 1.14  # the qualities differ, corners and gain do not
    low = abs(W_B.response(np.array(0.05))) / abs(W_D.response(np.array(0.05)))
    assert low == pytest.approx(0.4, rel=1e-3)  # well below all corners but the common band limit, K is left


@pytest.mark.parametrize(("axis", "weighting"), [(0, W_D), (1, W_D), (2, W_B)])
@pytest.mark.parametrize("frequency", [0.6, 1.4, 8.0])
def test_mean_comfort_of_a_sine(axis: int, weighting: Weighting, frequency: float) -> None:
    signals = [np.zeros_like(T)] * 3
    signals[axis] = 0.3 * np.sin(2 * np.pi * frequency * T)
    kept = T >= 20.0  # the filter's own start has died away: exp(-2 pi 0.4 0.707 20)
    windows = [window_rms(weighted(a, T, w)[kept], T[kept]) for a, w in zip(signals, (W_D, W_D, W_B), strict=True)]
    assert [w.size for w in windows] == [12, 12, 12]
    expected = 6 * 0.3 / np.sqrt(2) * abs(weighting.response(np.array(frequency)))
    assert mean_comfort(*windows) == pytest.approx(expected, rel=1e-4)  # windows hold whole periods; zero is padded far off


def test_directions_add_as_squares_and_the_95th_percentile_counts() -> None:
    windows = np.append(np.full(57, 0.1), [0.4, 0.4, 0.4])  # 3 of 60 windows are 5 %
    assert percentile(windows) == pytest.approx(0.1 + 0.05 * 0.3)  # the 57th of 60 and a twentieth of the way to the next
    assert mean_comfort(np.full(60, 0.2), np.full(60, 0.3), np.full(60, 0.6)) == pytest.approx(6 * 0.7)


def test_a_filter_hears_no_future() -> None:
    a = np.where(T > 30.0, np.sin(2 * np.pi * 3.0 * T), 0.0)
    before = np.abs(weighted(a, T, W_B)[T < 29.9])
    assert before.max() < 1e-3 * np.abs(weighted(a, T, W_B)).max()  # what the cut at half the sampling rate leaves


@pytest.mark.parametrize(("value", "word"), [(1.0, "very comfortable"), (1.5, "comfortable"), (3.4, "medium"), (9.0, "very un")])
def test_the_scale_has_words(value: float, word: str) -> None:
    assert verdict(value).startswith(word)


def test_wrong_use() -> None:
    with pytest.raises(ValueError, match="t must be evenly spaced"):
        weighted(np.zeros(3), np.array([0.0, 1e-3, 3e-3]), W_D)
    with pytest.raises(ValueError, match=r"the sampling rate must exceed 200 Hz for W_b, got 100"):
        weighted(np.zeros(11), np.linspace(0.0, 0.1, 11), W_B)
    with pytest.raises(ValueError, match="must be columns of equal length"):
        weighted(np.zeros(4), np.zeros(3), W_D)
    with pytest.raises(ValueError, match="must be as long as a window of 5 s, is 1 s"):
        window_rms(np.zeros(1001), np.linspace(0.0, 1.0, 1001))
