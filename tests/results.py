"""What the tests gave on a system, as a file for the site's page "What was tested"."""

import collections
import json
import platform

import fmpy

import host

EMULATORS = {"win64": "win64 under Wine", "aarch64-linux": "aarch64-linux under qemu"}


def write(folder, stats):
    """Writes how many tests of each module passed, failed and were skipped; `stats` are pytest's reports by outcome."""
    modules = collections.defaultdict(collections.Counter)
    for outcome in ("passed", "failed", "error", "skipped"):
        for report in stats.get(outcome, []):
            module = report.nodeid.split("::")[0].split("/")[-1]
            modules[module]["failed" if outcome == "error" else outcome] += 1
    folder.mkdir(parents=True, exist_ok=True)
    name = host.PLATFORM or fmpy.platform
    content = {
        "system": EMULATORS.get(host.PLATFORM, f"{name}: {platform.platform()}, Python {platform.python_version()}"),
        "modules": {module: dict(counts) for module, counts in sorted(modules.items())},
    }
    (folder / f"{name}.json").write_text(json.dumps(content, indent=1), "utf-8")
