"""A run seen live: who may see it and who steers it, the same bits when nothing is touched, and changes that can be repeated."""

import base64
import http.client
import json
import threading
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyro_cosim import simulate, system
from gyro_cosim.master import Options, open_network
from gyro_cosim.master.visiting import changeable
from gyro_cosim.report.live import Served, Steering
from gyro_cosim.report.live.film import Film
from gyro_cosim.slaves import Signal
from gyro_cosim.systems import Event, Scenario
from gyro_cosim.systems.scenario import read_scenario, written
from gyro_cosim.trajectory import read_results

SPEED = Signal("rotor_speed", "parameter", "rad/s", 0.0, -100.0, 100.0)
OFFERED = {"gyro": {"rotor_speed": SPEED}}


@pytest.fixture
def served():
    film = Film(2)
    film.add(0, np.array([0.0, 0.1]), np.array([[1.0, 2.0], [3.0, 4.0]]))
    with Served("<!doctype html>", film, Steering(film, OFFERED, step=1e-3, waits=True)) as made:
        yield made


def ask(served, method="GET", path="", body=None, **headers):
    """The answer: status, headers, text."""
    connection = http.client.HTTPConnection(served.host, timeout=5)
    connection.request(method, f"/{served.token}/{path}", body, {name.replace("_", "-"): text for name, text in headers.items()})
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, answer.headers, text


def cookie(served):
    return ask(served)[1]["Set-Cookie"].partition(";")[0]


def wish(served, steer, **wanted):
    own = {"Origin": f"http://{served.host}", "Content_Type": "application/json"}
    status, _, text = ask(served, "POST", "do", json.dumps(wanted), **own, **({"Cookie": steer} if steer else {}))
    return status, json.loads(text).get("error", "")


@contextmanager
def stream(served, steer=""):
    """Gives the events one after the other."""
    connection = http.client.HTTPConnection(served.host, timeout=5)
    connection.request("GET", f"/{served.token}/events", headers={"Cookie": steer})
    answer = connection.getresponse()
    yield (json.loads(line[5:]) for line in iter(answer.readline, b"") if line.startswith(b"data:"))
    connection.close()


def test_who_opens_the_page_first_steers_and_others_watch(served):
    steer = cookie(served)
    assert "Set-Cookie" not in ask(served)[1]
    for given, steers in ((steer, True), ("", False), ("steer=guessed", False)):
        with stream(served, given) as events:
            assert next(events)["steers"] is steers
    assert wish(served, steer, do="pause") == (200, "")
    assert wish(served, "", do="pause") == (403, "someone else steers this run")
    assert wish(served, "steer=guessed", do="pause") == (403, "someone else steers this run")


def test_nothing_is_there_without_the_token_or_from_another_page(served):
    steer = cookie(served)
    own = f"http://{served.host}"
    assert ask(served, Host="evil.example")[0] == 403  # a name that leads here, as in DNS rebinding
    assert ask(served, Origin="http://evil.example")[0] == 403
    assert ask(served, Sec_Fetch_Site="cross-site")[0] == 403
    assert ask(served, path="../nothing")[0] == 404
    connection = http.client.HTTPConnection(served.host, timeout=5)
    connection.request("GET", "/guessed/")
    assert connection.getresponse().status == 404
    connection.close()
    posted = {"method": "POST", "path": "do", "body": '{"do": "pause"}', "Cookie": steer}
    assert ask(served, **posted, Content_Type="application/json")[0] == 403
    assert ask(served, **posted, Content_Type="application/json", Origin="null")[0] == 403
    assert ask(served, **posted, Content_Type="text/plain", Origin=own)[0] == 415
    assert ask(served, **posted | {"body": " " * 4000}, Content_Type="application/json", Origin=own)[0] == 413
    policy = ask(served)[1]["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy


def test_only_this_machine_is_listened_to(served):
    assert served._server.server_address[0] == "127.0.0.1"


@pytest.mark.parametrize(
    ("wanted", "why"),
    [
        ({"do": "fly"}, "unknown wish"),
        ({}, "unknown wish"),
        ({"do": "set", "component": "gyro", "name": "rotor_spee", "value": 1}, "did you mean 'gyro.rotor_speed'?"),
        ({"do": "set", "component": "gyro", "name": "rotor_speed", "value": 101}, "gyro.rotor_speed must be at most 100"),
        ({"do": "set", "component": "gyro", "name": "rotor_speed", "value": None}, "gyro.rotor_speed must be a number, got None"),
        ({"do": "set", "component": "gyro", "name": "rotor_speed", "value": float("nan")}, "gyro.rotor_speed must"),
        ({"do": "pace", "value": 3}, "the pace must be one of 0, 0.1, 1, 10"),
        ({"do": "pace", "value": []}, "the pace must be one of 0, 0.1, 1, 10"),
    ],
)
def test_a_wish_that_cannot_be_is_refused_with_the_rule(served, wanted, why):
    status, said = wish(served, cookie(served), **wanted)
    assert (status, why in said) == (400, True), said
    assert served.steering._pending == {}


def test_a_viewer_is_sent_what_he_has_not_seen(served):
    with stream(served) as events:
        first, second = next(events), next(events)
        assert (first["anew"], first["rows"], second["anew"], second["rows"]) == (True, 2, False, 0)
        columns = np.frombuffer(base64.b64decode(first["columns"]), "<f4")
        assert columns.tolist() == [1.0, 3.0, 2.0, 4.0]
        served.film.add(2, np.array([0.2]), np.array([[5.0, 6.0]]))
        assert next(told["rows"] for told in events if told["rows"]) == 1


def test_more_viewers_than_there_is_room_for_are_turned_away(served):
    with stream(served) as first:
        next(first)
        held = [served.viewers.acquire(blocking=False) for _ in range(7)]
        assert all(held)
        status, _, text = ask(served, path="events")
        assert (status, json.loads(text)["error"]) == (503, "there may be 8 viewers, not more")
        for _ in held:
            served.viewers.release()


def test_the_film_stays_small_and_a_viewer_who_lags_begins_anew():
    film = Film(1)
    _, cursor = film.since(None)
    for k in range(0, 50_000, 500):
        points = np.arange(k, k + 500)
        film.add(k, points / 1e3, points[:, None].astype(float))
    frame, cursor = film.since(cursor)
    assert frame.anew
    assert 1500 < len(frame.t) <= 4096
    assert np.allclose(frame.t * 1e3, frame.values[:, 0], rtol=1e-12)
    assert np.unique(np.diff(frame.values[:, 0])).size == 1
    assert len(film.since(cursor)[0].t) == 0


class Often(Steering):
    """Visited every 50 macro steps at least, however long they take."""

    at_most = 50


def live(plan, script, *, in_process, stop=1.0):
    """A run of which `script` is told every point that is visited, and which it steers; with its Steering."""
    with open_network(plan, in_process=in_process) as network:
        offered = changeable(network)
    film = Film(10)
    steering = Often(film, offered, step=1e-3, waits=False)
    usual = steering.visit

    def visit(t):
        script(steering, t)
        return usual(t)

    steering.visit = visit
    return simulate(plan, in_process=in_process, stop=stop, options=Options(visitor=steering)), steering


@pytest.mark.parametrize("in_process", [False, True])
def test_a_run_that_is_only_looked_at_has_the_same_bits(in_process):
    plan = system("wheel-pair")
    seen, _ = live(plan, lambda steering, t: None, in_process=in_process)
    alone = simulate(plan, in_process=in_process, stop=1.0)
    assert np.array_equal(seen.trajectory.values, alone.trajectory.values)
    assert [b.residual for b in seen.energy] == [b.residual for b in alone.energy]


@pytest.mark.parametrize("in_process", [False, True])
def test_changes_on_the_way_are_a_scenario_that_gives_the_same_bits(in_process, tmp_path):
    def turn(steering, t):
        if t > 0.2 and not steering.events:
            steering.want({"do": "set", "component": "gyro", "name": "rotor_speed", "value": "300 rpm"})
        if t > 0.5 and len(steering.events) == 1:
            steering.want({"do": "set", "component": "vehicle", "name": "speed", "value": 9.1})

    plan = system("wheel-pair")
    seen, steering = live(plan, turn, in_process=in_process)
    assert [event.target for event in steering.events] == ["gyro.rotor_speed", "vehicle.speed"]
    assert seen.happened[0].words == "set gyro.rotor_speed to 31.4159"
    file = tmp_path / "changes.toml"
    file.write_text(written(Scenario(tuple(steering.events))), encoding="utf-8")
    again = simulate(replace(plan, scenario=read_scenario(file)), in_process=in_process, stop=1.0)
    assert np.array_equal(seen.trajectory.values, again.trajectory.values)
    assert [b.residual for b in seen.energy] == [b.residual for b in again.energy]
    assert not np.array_equal(seen.trajectory.values, simulate(plan, in_process=in_process, stop=1.0).trajectory.values)


def test_a_run_pauses_goes_on_and_ends_when_it_is_wanted():
    at = []

    def look(steering, t):
        at.append(t)
        if len(at) == 2:
            steering.want({"do": "pause"})
            threading.Timer(0.2, steering.want, ({"do": "go"},)).start()
        if len(at) == 3:
            steering.want({"do": "stop"})

    began = time.perf_counter()
    seen, _ = live(system("wheel-pair"), look, in_process=True, stop=60.0)
    assert time.perf_counter() - began > 0.2
    assert seen.status == "interrupted"
    assert seen.trajectory.t[-1] == at[2]


def test_every_event_of_a_scenario_comes_back_from_its_file(tmp_path):
    events = (
        Event(0.1, "set", "a.p", 1 / 3), Event(0.2, "ramp", "a.q", "3 rpm", 2.5), Event(0.3, "freeze", 'b."x\\y"'),
        Event(0.4, "offset", "b.x", 1e-300), Event(0.5, "restore", "b.x"), Event(0.6, "set", "c.on", True),
    )  # fmt: skip
    file = tmp_path / "s.toml"
    file.write_text(written(Scenario(events)), encoding="utf-8")
    assert read_scenario(file).events == events


def test_the_command_waits_for_a_viewer_and_its_results_say_how_to_repeat_them(cosim, monkeypatch):
    before, made = set(threading.enumerate()), []  # other tests may have left theirs
    monkeypatch.setattr(Served, "__enter__", lambda self, usual=Served.__enter__: made.append(self) or usual(self))

    def view():
        while not made:
            time.sleep(0.01)
        steer = cookie(made[0])
        assert wish(made[0], steer, do="pace", value=10)[0] == 200
        assert wish(made[0], steer, do="go")[0] == 200
        while not made[0].steering.told()["t"]:
            time.sleep(0.01)
        assert wish(made[0], steer, do="set", component="gyro", name="rotor_speed", value=50)[0] == 200

    viewer = threading.Thread(target=view)
    viewer.start()
    code, out, err = cosim("run", "wheel-pair", "--stop", "8", "--live", "--output", "r.csv")
    viewer.join()
    assert code == 0, err
    assert made[0].address in err
    assert "wrote wheel-pair-live.toml" in out
    assert "set gyro.rotor_speed to 50" in out
    assert not set(threading.enumerate()) - before
    with pytest.raises(ConnectionRefusedError):
        ask(made[0])
    origin = json.loads(Path("r.csv.origin.json").read_text(encoding="utf-8"))
    assert origin["command"] == ["run", "wheel-pair", "--stop", "8", "--output", "r.csv", "--scenario", "wheel-pair-live.toml"]
    assert cosim("run", "wheel-pair", "--stop", "8", "--scenario", "wheel-pair-live.toml", "--output", "again.csv")[0] == 0
    assert np.array_equal(read_results("r.csv").values, read_results("again.csv").values)


def test_live_shows_one_run(cosim):
    code, _, err = cosim("run", "wheel-pair", "--live", "--certify")
    assert (code, "--live shows one run" in err) == (2, True)
