"""Writes the files that others need to try the FMUs in their tools: for each FMU and platform, a folder in the layout
of the FMI cross-check, and the project's entry in the public list of FMI tools.

    compatibility/fmus/2.0/cs/linux64/plcfmu/0.1.0/CONT_C/CONT_C.fmu, CONT_C_in.csv, CONT_C_ref.csv, CONT_C_ref.opt, README.md
    compatibility/tools.json

The reference results are those in each FMU: recorded from its own library, with one step per call.
"""

import argparse
import json
import re
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

TOOL = "plcfmu"
# The platforms of the cross-check.
PLATFORMS = ("linux64", "win64", "darwin64")
REFERENCES = "extra/org.fmi-standard.fmi-ls-ref"

README = """# {name}, an FMU of {tool} {version}

{about}

`{name}_ref.csv` has the outputs after initialization and after each communication step, `{name}_in.csv` the inputs,
which are held from row to row, and `{name}_ref.opt` the times. {settings}
Every reference value was returned by the library in `{name}.fmu`. Importers that step according to the options compute
the same numbers to the last bit.
"""


def reference(package, name):
    """An FMU's reference experiment: (start, stop, step) in seconds, as strings, and the settings to be made before
    initialization ends, which the input file cannot contain."""
    text = package.read("documentation/fmi-ls-ref.txt").decode()
    times = re.search(r"^Start time (\S+) s, stop time (\S+) s, communication step (\S+) s", text, re.MULTILINE)
    if not times:
        raise ValueError(f"{name}.fmu: no times in documentation/fmi-ls-ref.txt")
    return times.groups(), re.findall(r"^Set before the initialization ends: (.+)$", text, re.MULTILINE)


def files(path, version):
    """The files in an FMU's folder, by name, and the platforms of the cross-check that the FMU supports."""
    name = path.stem
    with zipfile.ZipFile(path) as package:
        (start, stop, step), settings = reference(package, name)
        inputs, results = (package.read(f"{REFERENCES}/{name}_{kind}.csv") for kind in ("in", "out"))
        about = ElementTree.fromstring(package.read("modelDescription.xml")).get("description").split("\n")[0]
        folders = {entry.split("/")[1] for entry in package.namelist() if entry.startswith("binaries/")}
    settings = f"Set before the initialization ends: {', '.join(settings)}.\n" if settings else ""
    text = README.format(name=name, tool=TOOL, version=version, about=about, settings=settings)
    made = {
        f"{name}.fmu": path.read_bytes(),
        f"{name}_in.csv": inputs,
        f"{name}_ref.csv": results,
        f"{name}_ref.opt": f"StartTime, {start}\nStopTime, {stop}\nStepSize, {step}\nRelTol, 0.0\n".encode(),
        "README.md": text.encode(),
    }
    return made, [platform for platform in PLATFORMS if platform in folders]


def entry(address):
    """The entry in the list of tools; `address` is the URL of the published project."""
    return {
        "name": TOOL,
        "license": "osi",
        "url": address,
        "vendor": TOOL,
        "vendorURL": address,
        "examplesURL": f"{address}examples/index.html",
        "description": "PLC control blocks as FMUs, and closed loops of FMUs on the command line: run, study, tune",
        "features": [],
        "platforms": ["Linux", "Windows"],
        "interfaces": ["CLI", "GUI", "library"],
        "fmiVersions": ["2.0"],
        "fmuExport": ["CS"],
        "fmuImport": ["CS"],
        "layeredStandards": [],
    }


def write(fmus, out, version, address=""):
    """Writes the folder `out`. Without an address, the list of tools gets no entry, because the entry requires one."""
    for path in sorted(Path(fmus).glob("*.fmu")):
        made, platforms = files(path, version)
        for platform in platforms:
            folder = Path(out) / "fmus" / "2.0" / "cs" / platform / TOOL / version / path.stem
            folder.mkdir(parents=True, exist_ok=True)
            for name, content in made.items():
                (folder / name).write_bytes(content)
    if address:
        text = json.dumps(entry(address.rstrip("/") + "/"), indent=4)
        (Path(out) / "tools.json").write_text(f"{text}\n", "utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--fmus", required=True, help="folder of the FMUs")
    parser.add_argument("--out", required=True, help="folder to write")
    parser.add_argument("--version", required=True, help="version of plcfmu")
    parser.add_argument("--address", default="", help="URL of the project, for its entry in the list of tools")
    arguments = parser.parse_args()
    try:
        write(arguments.fmus, arguments.out, arguments.version, arguments.address)
    except (KeyError, ValueError) as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
