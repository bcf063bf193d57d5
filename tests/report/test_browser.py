"""The page in a real browser: what is drawn, what runs, what keys do. Needs playwright and a Chromium on the machine."""

import shutil
import subprocess

import pytest

from gyro_cosim import simulate, system
from gyro_cosim.report import Told, bundling, write_report

playwright = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
SOFTWARE_GL = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")]
DONE = ".status[data-state=done], .status[data-state=failed]"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The vehicle in the curve at 8 m/s with the gyro units spinning, 12 s."""
    plan = system("lrt-curve").with_value("vehicle.speed", 8.0)
    for unit in ("gyro_front", "gyro_rear"):
        plan = plan.with_value(f"{unit}.rotor_speed", 209.43951)
    run = simulate(plan, stop=12.0)
    assert run.status == "done"
    made = tmp_path_factory.mktemp("page") / "curve.html"
    write_report(made, run, Told(command="cosim run lrt-curve", lines=["passed"], variants=["off_full"]))
    return made


@pytest.fixture
def page(file):
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE_GL)
        tab = browser.new_page(viewport={"width": 1200, "height": 900})
        tab.complaints = []
        tab.on("console", lambda message: tab.complaints.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: tab.complaints.append(str(error)))
        tab.on("request", lambda request: tab.complaints.append(request.url) if request.url.startswith("http") else None)
        tab.goto(file.as_uri())
        tab.wait_for_selector("html[data-ready=yes]", timeout=60_000)
        yield tab
        assert tab.complaints == []
        browser.close()


def pixels(page, selector):
    """How many different colours a canvas shows."""
    script = """canvas => {
      const copy = document.createElement("canvas");
      [copy.width, copy.height] = [canvas.width, canvas.height];
      const context = copy.getContext("2d");
      context.drawImage(canvas, 0, 0);
      const data = new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
      return new Set(data).size;
    }"""
    return page.eval_on_selector(selector, script)


def set_parameter(page, name, value):
    page.fill("#again input[type=search]", name)
    field = page.locator("#again .parameters input[type=number]").first
    field.fill(value)
    field.dispatch_event("change")


def test_an_unchanged_run_in_the_page_is_identical_to_the_stored_one(page):
    page.click("#again button.main")
    page.wait_for_selector(DONE, timeout=120_000)
    assert "Reproduced: identical, to the last bit" in page.inner_text(".status")
    assert page.get_attribute(".status", "data-reproduced") == "identical"


def test_with_the_rotors_stopped_the_vehicle_in_the_page_derails(page):
    for unit in ("gyro_front", "gyro_rear"):
        set_parameter(page, f"{unit}.rotor_speed", "0")
    page.fill("#stop-time", "20")
    page.dispatch_event("#stop-time", "change")
    page.click("#again button.main")
    page.wait_for_selector(DONE, timeout=120_000)
    assert "Ended at t = " in page.inner_text(".status")
    assert "derailed" in page.inner_text(".status")


def test_the_menu_puts_another_variant_in_place(page):
    page.select_option("#variant", "off_full")
    page.wait_for_function("document.querySelector('.status').innerText.includes('off_full in place')")
    page.fill("#stop-time", "20")
    page.click("#again button.main")
    page.wait_for_selector(DONE, timeout=120_000)
    assert "derailed" in page.inner_text(".status")
    page.select_option("#variant", "")
    page.fill("#stop-time", "12")
    page.click("#again button.main")
    page.wait_for_selector("[data-reproduced=identical]", timeout=120_000)


def test_plots_and_the_vehicle_are_drawn_and_the_animation_moves(page):
    assert pixels(page, "#signals .chart canvas") > 5
    before = pixels(page, ".stage canvas")
    assert before > 50
    clock = page.inner_text(".play output")
    page.focus(".play button.main")
    page.keyboard.press("Enter")
    page.wait_for_timeout(1500)
    page.keyboard.press("Enter")
    assert page.inner_text(".play output") != clock


def test_a_value_outside_its_bounds_is_refused_and_the_page_stays_usable(page):
    set_parameter(page, "gyro_front.rotor_inertia", "-1")
    assert "gyro_front.rotor_inertia must be at least 0, got -1" in page.inner_text(".status")
    page.click("#again button.main")
    page.wait_for_selector(DONE, timeout=120_000)
    assert page.get_attribute(".status", "data-state") == "done"


@pytest.fixture(scope="module")
def workshop():
    """The page's sources with all their packages, those for development among them."""
    with bundling.built_in() as (node, folder):
        yield node, folder


def test_the_types_of_the_scripts_agree(workshop):
    node, folder = workshop
    check = [node.program, str(folder / "node_modules" / "typescript" / "bin" / "tsc"), "-p", str(folder / "tsconfig.json")]
    done = subprocess.run(check, cwd=folder, capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == []
    assert done.returncode == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(page, workshop, scheme):
    page.emulate_media(color_scheme=scheme)
    page.evaluate("for (const closed of document.querySelectorAll('details')) closed.open = true")
    page.evaluate((workshop[1] / "node_modules" / "axe-core" / "axe.min.js").read_text(encoding="utf-8"))
    found = page.evaluate("axe.run(document, { resultTypes: ['violations'] }).then((said) => said.violations)")
    grave = [(v["id"], v["nodes"][0]["html"]) for v in found if v["impact"] in ("serious", "critical")]
    assert grave == []


def test_the_page_prints_whole(page, tmp_path):
    made = tmp_path / "page.pdf"
    page.pdf(path=str(made), format="A4")
    assert made.stat().st_size > 50_000
    page.emulate_media(media="print")
    assert not page.is_visible("#again")
    assert page.is_visible("#signals .chart canvas")


def test_the_page_fits_a_phone(page):
    page.set_viewport_size({"width": 390, "height": 800})
    page.wait_for_timeout(300)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_everything_is_reached_by_keys_and_has_a_name(page):
    unnamed = page.eval_on_selector_all(
        "button, input, select, canvas[tabindex]",
        """all => all.filter(e => !e.innerText?.trim() && !e.getAttribute("aria-label") && !e.labels?.length)
                     .map(e => e.outerHTML)""",
    )
    assert unnamed == []
    seen = set()
    for _ in range(25):
        page.keyboard.press("Tab")
        seen.add(page.evaluate("[...document.querySelectorAll('*')].indexOf(document.activeElement)"))
    assert len(seen) == 25
