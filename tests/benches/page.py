"""How long the page's main thread is blocked while it shows a program of 2,000 lines that runs at x10.

`target/venv/bin/python tests/benches/page.py`. The page is that of PLCFMU_TOOL, or target/tool/plcfmu-tool.html. A timer in the
page records how late it fires: while the page is busy, it cannot respond to a key or a click. The target is at most 100 ms.
PLCFMU_BENCH_SECONDS is the measuring time for each view.
"""

import os
import pathlib
import statistics
import sys

from playwright.sync_api import sync_playwright

sys.path.insert(0, str(pathlib.Path(__file__).parents[1]))
import tool  # noqa: E402

LINES = 2000
SECONDS = float(os.environ.get("PLCFMU_BENCH_SECONDS", 20))
# The minimum delay of a browser between two nested timers, in milliseconds.
PAUSE = 4
AIM = 100

NOTE = """(pause) => {
  globalThis.late = [];
  let last = performance.now();
  const tick = () => {
    const now = performance.now();
    globalThis.late.push(Math.max(now - last - pause, 0));
    last = now;
    globalThis.timer = setTimeout(tick, pause);
  };
  globalThis.timer = setTimeout(tick, pause);
}"""
DROP = """(text) => {
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([text], "large.scl"));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
}"""
CALLS = "async () => (await moduleOf('tool/store.js')).store.state?.calls ?? 0"


def program():
    """A block of 2,000 lines: stations with a counter, a filter and a flag each, all of which change constantly."""
    declared, code = [], []
    number = 0
    while len(declared) + len(code) + 9 < LINES:
        number += 1
        declared += [f"  n{number} : Int;", f"  x{number} : Real;", f"  on{number} : Bool;", f"  done{number} : Bool;"]
        before = f"#done{number - 1}" if number > 1 else "#start"
        code += [
            f"  IF #on{number} AND NOT #done{number} OR {before} AND #n{number} < {3 + number % 7} THEN",
            f"    #n{number} := #n{number} + 1;",
            "  ELSE",
            f"    #n{number} := 0;",
            "  END_IF;",
            f"  #on{number} := #n{number} MOD 3 = 1;",
            f"  #done{number} := #n{number} > 2 AND #x{number} < 100.0;",
            f"  #x{number} := #x{number} + 0.1 * (INT_TO_REAL(#n{number}) - #x{number});",
        ]
    head = ['FUNCTION_BLOCK "Large"', "VAR_INPUT start : Bool := TRUE; END_VAR", "VAR_OUTPUT level : Real; busy : Bool; END_VAR", "VAR"]
    tail = [f"  #level := #x{number};", f"  #busy := #on{number} OR #on1;", "END_FUNCTION_BLOCK"]
    lines = [*head, *declared, "END_VAR", "BEGIN", *code, *tail]
    return "\n".join([*lines, *["// "] * (LINES - len(lines))]) + "\n"


def measured(page, scrolls):
    """How late each timer fired, in milliseconds, and the number of calls per second."""
    before = page.evaluate(CALLS)
    page.evaluate(NOTE, PAUSE)
    for _ in range(round(SECONDS)):
        if scrolls:
            page.locator(".program .source").evaluate("(one) => one.scrollBy(0, 400)")
        page.wait_for_timeout(1000)
    late = page.evaluate("() => { clearTimeout(globalThis.timer); return globalThis.late; }")
    return late, (page.evaluate(CALLS) - before) / SECONDS


def main():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=tool.CHROMIUM, args=tool.ARGUMENTS)
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        page.goto(tool.PAGE.as_uri())
        page.locator("#new-block option").first.wait_for(state="attached")
        page.evaluate(NOTE, PAUSE)
        page.evaluate(DROP, program())
        page.locator(f'.program [data-line="{LINES}"]').wait_for(state="attached")
        opened = max(page.evaluate("() => { clearTimeout(globalThis.timer); return globalThis.late; }"))
        print(f"opening a program of {LINES} lines: the page is blocked for {opened:.0f} ms at once")
        page.get_by_role("group", name="Speed").get_by_role("button", name="×10").click()
        page.get_by_role("button", name="Run", exact=True).click()
        page.wait_for_timeout(2000)
        print(f"at x10, for {SECONDS:.0f} s each; aim {AIM} ms\n")
        print("| view | cycles in 1 s | median | 99 % | longest | above the aim |")
        print("|---|---|---|---|---|---|")
        for name, scrolls in [("the source stands", False), ("the source is scrolled", True)]:
            late, calls = measured(page, scrolls)
            above = sum(one > AIM for one in late)
            share = statistics.quantiles(late, n=100, method="inclusive")[98]
            print(f"| {name} | {calls:.0f} | {statistics.median(late):.1f} ms | {share:.0f} ms | {max(late):.0f} ms | {above} |")
        browser.close()


main()
