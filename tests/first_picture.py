"""Measures when the parameter tool shows its first curve, with the processor at a quarter of its speed: `python
tests/first_picture.py [ROUNDS]`.

The page is that of PLCFMU_TOOL, or target/tool/plcfmu-tool.html (`cargo xtask tool`), opened from a file in a browser that has not
seen it. Prints the median, in milliseconds after the navigation began, of the first paint, of the frame with the curve, and of the
engine's first answer.
"""

import statistics
import sys

from playwright.sync_api import sync_playwright

from tool import ARGUMENTS, CHROMIUM, PAGE

SLOWER = 4
WATCH = """
globalThis.seen = {};
const look = () => {
  if (!seen.curve && document.querySelector(".living svg path")) seen.curve = performance.now();
  if (!seen.engine && document.querySelector("#new-block option")) seen.engine = performance.now();
  if (!seen.engine) requestAnimationFrame(look);
};
requestAnimationFrame(look);
"""


def main(rounds):
    taken = {"first paint": [], "curve": [], "engine": []}
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        for _ in range(rounds):
            context = browser.new_context(viewport={"width": 1366, "height": 768})
            page = context.new_page()
            context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": SLOWER})
            page.add_init_script(WATCH)
            page.goto(PAGE.as_uri())
            page.wait_for_function("() => seen.engine")
            seen = page.evaluate("() => seen")
            paint = page.evaluate("() => performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? NaN")
            for name, at in (("first paint", paint), *seen.items()):
                taken[name].append(at)
            context.close()
        browser.close()
    for name, times in taken.items():
        print(f"{name}: {statistics.median(times):.0f} ms ({min(times):.0f} to {max(times):.0f}, {rounds} times)")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 9)
