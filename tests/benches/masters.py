"""Steps the loop of benches/study.rs with another master: `masters.py MASTER FMUS LOOP.ssp STEP`.

Reads a number of steps from each line of standard input and answers with the time per step in nanoseconds. MASTER is fmpy
(FMU2Slave, one Python call at a time), ecos or libcosim (both step natively, many steps in one call, with nothing read in between).
"""

import pathlib
import sys
import tempfile
import time
import zipfile


def fmpy(folder, step):
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    directory = tempfile.TemporaryDirectory()
    slaves, references = [], []
    for name, start in [
        ("CONT_C", {"MAN_ON": False, "SP_INT": 200.0, "GAIN": 1.4, "TI": 80.0, "CYCLE": step}),
        ("HEATER", {"CYCLE": step}),
    ]:
        path = str(folder / f"{name}.fmu")
        description = fmpy.read_model_description(path)
        unpacked = fmpy.extract(path, str(pathlib.Path(directory.name) / name))
        slave = FMU2Slave(guid=description.guid, unzipDirectory=unpacked,
                          modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
        of = {variable.name: variable.valueReference for variable in description.modelVariables}
        slave.instantiate()
        for variable, value in start.items():
            (slave.setBoolean if isinstance(value, bool) else slave.setReal)([of[variable]], [value])
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slaves.append(slave)
        references.append(of)
    controller, plant = slaves
    process_value, power = [references[0]["PV_IN"]], [references[1]["POWER"]]
    signals, temperature = [references[0][name] for name in ("LMN", "PV", "SP_INT")], [references[1]["TEMP"]]
    made, rows, temp = 0, [], plant.getReal(temperature)

    def steps(count):
        nonlocal made, temp
        rows.clear()
        begin = time.perf_counter_ns()
        for number in range(made, made + count):
            now = number * step
            controller.setReal(process_value, temp)
            controller.doStep(now, step)
            row = controller.getReal(signals)
            rows.append(row)
            plant.setReal(power, row[:1])
            plant.doStep(now, step)
            temp = plant.getReal(temperature)
        duration = time.perf_counter_ns() - begin
        made += count
        return duration

    steps.keep = directory
    return steps


def ecos(ssp, step):
    import ecospy

    directory = tempfile.TemporaryDirectory()
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(directory.name)
    simulation = ecospy.EcosSimulation(step_size=step, ssp_path=directory.name)
    assert simulation.init(parameter_set="start")

    def steps(count):
        begin = time.perf_counter_ns()
        simulation.step(count)
        return time.perf_counter_ns() - begin

    steps.keep = directory, simulation
    return steps


def libcosim(ssp, step):
    from libcosimpy import CosimExecution, CosimLogging

    CosimLogging.log_output_level(CosimLogging.CosimLogLevel.ERROR)
    execution = CosimExecution.CosimExecution.from_ssp_file(str(ssp), round(step * 1e9))

    def steps(count):
        begin = time.perf_counter_ns()
        assert execution.step(count)
        return time.perf_counter_ns() - begin

    return steps


def main():
    master, folder, ssp, step = sys.argv[1:]
    step = float(step)
    steps = fmpy(pathlib.Path(folder), step) if master == "fmpy" else {"ecos": ecos, "libcosim": libcosim}[master](ssp, step)
    print("ready", flush=True)
    for line in sys.stdin:
        count = int(line)
        print(steps(count) / count, flush=True)


if __name__ == "__main__":
    main()
