"""Draw the picture of the README's page of a run in a headless browser: results/gallery/report.png.

Needs playwright, which the development extra brings, and a Chromium on the machine.
"""

import shutil
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

OUT = Path("results/gallery")
PAGE = OUT / "curve.html"
RUN = ["run", "lrt-curve", "--set", "vehicle.speed=8", "--set", "gyro.rotor_speed=2000rpm", "--stop", "20", "--report", str(PAGE)]
WEBGL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-sandbox"]
MOMENT = "9.6"  # s, in the curve

chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
if chromium is None:
    sys.exit("a Chromium must be on the machine")
OUT.mkdir(parents=True, exist_ok=True)
subprocess.run([sys.executable, "-m", "gyro_cosim", *RUN], check=True, stdout=subprocess.DEVNULL)
with sync_playwright() as driver:
    browser = driver.chromium.launch(executable_path=chromium, args=WEBGL)
    tab = browser.new_page(viewport={"width": 1100, "height": 720}, device_scale_factor=1.25)
    tab.goto(PAGE.absolute().as_uri())
    tab.wait_for_selector("html[data-ready=yes]")
    tab.eval_on_selector(
        ".play input[type=range]",
        f"field => {{ field.value = {MOMENT}; field.dispatchEvent(new Event('input')); }}",
    )
    tab.evaluate("document.querySelector('.stage').closest('section').scrollIntoView()")
    tab.wait_for_timeout(1000)
    tab.screenshot(path=str(OUT / "report.png"))
    browser.close()
