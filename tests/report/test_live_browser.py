"""The page of a run that goes on, in a real browser: one steers, another watches. Needs playwright and a Chromium."""

import threading

import pytest
from test_browser import CHROMIUM, SOFTWARE_GL

from gyro_cosim import simulate, system
from gyro_cosim.master import Options, open_network
from gyro_cosim.master.visiting import changeable
from gyro_cosim.report.bundling import bundle
from gyro_cosim.report.live import Served, Steering, first_page
from gyro_cosim.report.live.film import Film
from gyro_cosim.report.writing import page
from gyro_cosim.systems import catalogue

playwright = pytest.importorskip("playwright.sync_api")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")]


@pytest.fixture
def served():
    """The vehicle in the curve, which waits for its start; the run is in a thread of its own."""
    plan = system("lrt-curve").with_value("vehicle.speed", 8.0)
    with open_network(plan) as network:
        offered, names = changeable(network), list(network.names)
        document = first_page(network, names, offered, start=0.0, stop=20.0, command="cosim run", prefer=(), paced=False)
    film = Film(len(names))
    steering = Steering(film, offered, step=plan.step, waits=True)
    runs = []
    with Served(page(document, bundle(catalogue.cache_folder())), film, steering) as made:
        work = threading.Thread(target=lambda: runs.append(simulate(plan, stop=20.0, options=Options(visitor=steering))))
        work.start()
        yield made
        steering.want({"do": "stop"})
        work.join()
    assert runs[0].happened[0].words == "set gyro_front.rotor_speed to 150"


def test_one_steers_and_another_watches(served):
    complaints = []
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE_GL)
        steers, watches = browser.new_context().new_page(), browser.new_context(viewport={"width": 390, "height": 800}).new_page()
        for tab in (steers, watches):
            tab.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
            tab.on("pageerror", lambda error: complaints.append(str(error)))
            tab.goto(served.address)
            tab.wait_for_selector(".status[data-state=waiting]")
        assert "You watch" in watches.inner_text(".status")
        assert watches.is_disabled("#steer button.main")
        steers.select_option("#pace", "1")
        steers.click("#steer button.main")
        steers.wait_for_selector(".status[data-state=running]")
        field = steers.locator("#live-gyro_front-rotor_speed")
        field.fill("3000")
        field.dispatch_event("change")
        steers.wait_for_selector("#steer [role=alert]:not([hidden])")
        assert "gyro_front.rotor_speed must be at most 2000" in steers.inner_text("#steer [role=alert]")
        field.fill("150")
        field.dispatch_event("change")
        for tab in (steers, watches):
            tab.wait_for_selector("#steer .changes td")
            tab.wait_for_selector(".chart canvas")
            tab.wait_for_selector(".stage canvas")
        steers.click("text=Pause")
        watches.wait_for_selector(".status[data-state=paused]")
        assert watches.evaluate("document.documentElement.scrollWidth") <= 390
        browser.close()
    refused = [text for text in complaints if "400 (Bad Request)" in text]  # as browsers tell of the speed of 3000
    assert (len(refused), len(complaints)) == (1, 1), complaints
