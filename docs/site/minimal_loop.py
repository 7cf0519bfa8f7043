import fmpy
from fmpy.fmi2 import FMU2Slave

STEP = 1.0  # s


def start(path):
    description = fmpy.read_model_description(path)
    identifier = description.coSimulation.modelIdentifier
    slave = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(path), modelIdentifier=identifier)
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    return slave, {variable.name: variable.valueReference for variable in description.modelVariables}


controller, of = start("CONT_C.fmu")
plant, at = start("HEATER.fmu")
controller.setBoolean([of["MAN_ON"]], [False])
controller.setReal([of[name] for name in ("CYCLE", "SP_INT", "GAIN", "TI")], [STEP, 60.0, 0.7, 130.0])
controller.exitInitializationMode()
plant.exitInitializationMode()
for k in range(900):
    controller.setReal([of["PV_IN"]], plant.getReal([at["TEMP"]]))
    controller.doStep(k * STEP, STEP)
    plant.setReal([at["POWER"]], controller.getReal([of["LMN"]]))
    plant.doStep(k * STEP, STEP)
print(*plant.getReal([at["TEMP"]]))
