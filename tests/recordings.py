"""Makes the recordings in tests/recordings: loops whose controller has other settings than its file, as the product writes them.

    python tests/recordings.py [COMMAND]

`run` is `plcfmu run --out`, `page` the CSV of the parameter tool, `clock` a recorder that is four times as fast as the controller. Each is
written with all digits or with three decimals. What is wrong in each is in `RECORDINGS`, which the test reads as well.
"""

import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import tool

FOLDER = pathlib.Path(__file__).parent / "recordings"
FMUS = tool.ROOT / "target/fmu"

# What is recorded of each controller: what it is given, and what it gives.
RECORDED = {
    "CONT_C": ["SP_INT", "PV_PER", "PV_IN", "LMN"],
    "CONT_S": ["SP_INT", "PV_IN", "LMNR_HS", "LMNR_LS", "QLMNUP", "QLMNDN"],
    "PULS_CTR": ["SP_INT", "PV_PER", "QPOS_P", "DI_CONT_C.LMN"],
    "PULSEGEN": ["INV", "QPOS_P", "QNEG_P"],
    "HLG": ["E01", "INIT", "HLG"],
}

# A loop, its controller, and what happens in it: a step of the setpoint, and in some a disturbance.
LOOPS = {
    "furnace": ("CONT_C", {"step": 1.0, "stop": 400.0}, [(200.0, {"CONT_C.SP_INT": 75.0}), (300.0, {"HEATER.DOOR": 20.0})]),
    "process": ("CONT_C", {"step": 0.1, "stop": 40.0}, [(20.0, {"CONT_C.SP_INT": 45.0}), (30.0, {"PROCESS.LOAD": 10.0})]),
    "zone": ("CONT_C", {"step": 1.0, "stop": 400.0}, [(200.0, {"CONT_C.SP_INT": 10.0})]),
    "valve": ("CONT_S", {"step": 0.1, "stop": 50.0}, [(25.0, {"CONT_S.SP_INT": 56.0})]),
    "chamber": ("PULS_CTR", {"step": 0.01, "stop": 6.0}, [(3.0, {"PULS_CTR.SP_INT": 65.0})]),
    "pulses": (
        *("PULSEGEN", {"step": 0.1, "stop": 60.0}),
        [(15.0, {"CONT_C.SP_INT": 40.0}), (30.0, {"CONT_C.SP_INT": 5.0}), (45.0, {"CONT_C.SP_INT": 45.0})],
    ),
    "speed": ("HLG", {"step": 0.01, "stop": 5.0}, [(2.0, {"HLG.E01": True}), (3.5, {"HLG.E01": False})]),
}

# A pulse generator behind a continuous controller, which none of the known loops has.
PULSES = """
[fmus]
CONT_C = "CONT_C.fmu"
PULSEGEN = "PULSEGEN.fmu"
THERMO = "THERMO.fmu"

[connections]
CONT_C.LMN = "PULSEGEN.INV"
PULSEGEN.QPOS_P = "THERMO.HEAT"
PULSEGEN.QNEG_P = "THERMO.COOL"
THERMO.TEMP = "CONT_C.PV_IN"

[settings]
CONT_C = { MAN_ON = false, SP_INT = 30.0, LMN_LLM = -100.0, GAIN = 0.8, TI = 8.0, CYCLE = 0.1 }
PULSEGEN = { PER_TM = 2.0, P_B_TM = 0.1, STEP3_ON = true, ST2BI_ON = false, CYCLE = 0.1 }
THERMO = { HEAT_TM = 1.0, ZONE_TM = 10.0, CYCLE = 0.1 }
"""

# Loop, what is wrong at the plant, how it is recorded, and how many decimals there are: all without a number.
RECORDINGS = [
    ("furnace", {}, "run", None),
    ("furnace", {"GAIN": 1.0}, "run", None),
    ("furnace", {"TI": 90.0}, "run", 3),
    ("furnace", {"GAIN": 1.0, "TI": 90.0}, "page", None),
    ("furnace", {"GAIN": 1.2}, "page", 3),
    ("furnace", {"LMN_HLM": 22.0}, "run", None),
    ("furnace", {"DEADB_W": 0.5}, "run", 3),
    ("furnace", {"PV_FAC": 4.2}, "run", None),
    ("furnace", {"CYCLE": 2.0}, "run", None),
    ("furnace", {"TI": 200.0}, "clock", 3),
    ("furnace", {"GAIN": 0.5, "TI": 60.0}, "clock", None),
    ("process", {}, "page", 3),
    ("process", {"GAIN": 3.5}, "page", None),
    ("process", {"TI": 5.0}, "page", 3),
    ("process", {"GAIN": 3.0, "TI": 12.0}, "run", 3),
    ("process", {"D_SEL": True}, "run", None),
    ("process", {"LMN_HLM": 60.0}, "run", 3),
    ("process", {"TI": 6.0, "LMN_HLM": 70.0}, "run", None),
    ("process", {"CYCLE": 0.2}, "page", None),
    ("zone", {"GAIN": 6.0}, "run", None),
    ("zone", {"TI": 60.0}, "clock", None),
    ("zone", {"LMN_LLM": -60.0}, "run", 3),
    ("zone", {"DEADB_W": 0.3}, "page", None),
    ("valve", {}, "run", None),
    ("valve", {"GAIN": 2.0}, "run", None),
    ("valve", {"TI": 4.0}, "run", 3),
    ("valve", {"PULSE_TM": 0.4}, "page", None),
    ("valve", {"MTR_TM": 20.0}, "page", 3),
    ("valve", {"BREAK_TM": 0.5}, "run", None),
    ("valve", {"DEADB_W": 1.0}, "run", 3),
    ("valve", {"GAIN": 1.8, "TI": 9.0}, "run", None),
    ("chamber", {}, "page", None),
    ("chamber", {"DI_CONT_C.GAIN": 2.0}, "page", None),
    ("chamber", {"DI_CONT_C.TI": 5.0}, "run", 3),
    ("chamber", {"DI_CONT_C.GAIN": 4.0, "DI_CONT_C.TI": 15.0}, "run", None),
    ("chamber", {"RED_FAC": 25}, "page", 3),
    ("chamber", {"DI_PULSEGEN.P_B_TM": 0.04}, "run", None),
    ("pulses", {}, "run", 3),
    ("pulses", {"PER_TM": 3.0}, "run", None),
    ("pulses", {"P_B_TM": 0.4}, "page", 3),
    ("pulses", {"RATIOFAC": 2.0}, "run", 3),
    ("speed", {}, "run", 3),
    ("speed", {"TH_TZ": 300.0}, "run", None),
    ("speed", {"TR_TZ": 500.0}, "page", 3),
    ("speed", {"TH_TZ": 250.0, "TR_TZ": 300.0}, "run", None),
    ("speed", {"TR_TZ": 250.0}, "page", None),
]


def file_name(loop, wrong, way, decimals):
    """The name of a recording, which says all of it."""
    values = [f"{name.split('.')[-1]}={value:g}" if not isinstance(value, bool) else name for name, value in wrong.items()]
    digits = "all" if decimals is None else f"{decimals}"
    return "_".join([loop, *(values or ["right"]), way, digits]) + ".csv"


def description(loop):
    """The loop's text and its tables."""
    text = PULSES if loop == "pulses" else (tool.ROOT / f"plants/loops/{loop}.toml").read_text()
    tables = tomllib.loads(text)
    return text, tables


def settings(loop):
    """What the controller's file has: its settings by their names."""
    controller, *_ = LOOPS[loop]
    flat = {}

    def add(prefix, table):
        for name, value in table.items():
            add(f"{prefix}{name}.", value) if isinstance(value, dict) else flat.update({prefix + name: value})

    add("", description(loop)[1]["settings"][controller])
    return flat


def columns(loop):
    """What is recorded of a loop."""
    controller, *_ = LOOPS[loop]
    other = "PV_IN" if loop == "furnace" else "PV_PER"
    return [f"{controller}.{name}" for name in RECORDED[controller] if controller != "CONT_C" or name != other]


def by_command(command, loop, wrong, way):
    """What `plcfmu run --out` writes."""
    controller, of, events = LOOPS[loop]
    text = description(loop)[0].split("[[events]]")[0]
    given = {f"{controller}.{name}": value for name, value in wrong.items()}
    sets = [f"{name}={json.dumps(value)}" for name, value in given.items()]
    sets += [f"{name}={json.dumps(value)}@{time}" for time, values in events for name, value in values.items()]
    step = of["step"] / 4 if way == "clock" else of["step"]
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "loop.toml"
        file.write_text(text)
        options = [option for name in columns(loop) for option in ("--record", name)]
        options += ["--fmus", FMUS, "--step", step, "--stop", of["stop"], "--out", "-", "--quiet"]
        options += [option for one in sets for option in ("--set", one)]
        run = [command, "run", file, *map(str, options)]
        return subprocess.run(run, capture_output=True, text=True, check=True).stdout


def by_page(server, loop, wrong):
    """What the parameter tool exports, with its curves."""
    controller, of, events = LOOPS[loop]
    _, tables = description(loop)

    def ask(**request):
        answer = json.loads(server.ask(request, loop))
        assert "ok" in answer, answer
        return answer["ok"]

    members = []
    for name, fmu in tables["fmus"].items():
        values = {}

        def add(prefix, table, values=values):
            for key, value in table.items():
                add(f"{prefix}{key}.", value) if isinstance(value, dict) else values.update({prefix + key: value})

        add("", tables["settings"].get(name, {}))
        members.append({"name": name, "fmu": fmu.removesuffix(".fmu"), "values": values | (wrong if name == controller else {})})
    connections = [[f"{name}.{output}", to] for name, outputs in tables["connections"].items() for output, to in outputs.items()]
    exchange = tables.get("exchange", "sequential")
    ask(do="start", members=members, connections=connections, step=of["step"], exchange=exchange)
    done = 0
    for time, values in [*events, (of["stop"], {})]:
        ask(do="run", calls=round(time / of["step"]) - done)
        done = round(time / of["step"])
        if values:
            ask(do="send", values=values)
    return base64.b64decode(ask(do="export", what="csv", variables=columns(loop))["content"]).decode()


def rounded(text, decimals):
    """The CSV with so many decimals in its numbers; the times stay."""
    header, *rows = text.splitlines()

    def cell(value):
        return f"{float(value):.{decimals}f}" if "." in value or "e" in value else value

    return "\n".join([header, *(",".join([row[0], *map(cell, row[1:])]) for row in (row.split(",") for row in rows))]) + "\n"


def main(command):
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, tool.Server(command, folder, "--fmus", FMUS) as server:
        for loop, wrong, way, decimals in RECORDINGS:
            text = by_page(server, loop, wrong) if way == "page" else by_command(command, loop, wrong, way)
            text = text if decimals is None else rounded(text, decimals)
            (FOLDER / file_name(loop, wrong, way, decimals)).write_text(text)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else tool.ROOT / "target/debug/plcfmu")
