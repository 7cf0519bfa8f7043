"""The plants and the loops with them, written a second time.

The library solves each plant in closed form, in Rust. Here the differential equations of the plants' documentation are integrated
step by step; the controllers are those of oracle.py. `simulated` runs the description of a loop with them, call by call: nothing of it
has been taken from the Rust text. It runs what the loops of tests need: members with one call a step, connections of single variables,
settings and events.
"""

import math

import numpy as np
import oracle

G = 9.81
LITRE_PER_MINUTE = 1 / 60_000
# Into so many steps a call is divided.
STEPS = 10


def integrated(slope, state, seconds, steps):
    """The state after a time: Runge and Kutta's classical method of fourth order."""
    h = seconds / steps
    for _ in range(steps):
        k1 = slope(state)
        k2 = slope([x + h / 2 * k for x, k in zip(state, k1)])
        k3 = slope([x + h / 2 * k for x, k in zip(state, k2)])
        k4 = slope([x + h * k for x, k in zip(state, k3)])
        state = [x + h / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4)]
    return state


def limited(value, low, high):
    return min(max(value, low), high)


def analog(value, at_0, at_100):
    """What PV_PER gets: the nearest count of 0 ... 27648."""
    return round(limited(27648 * (value - at_0) / (at_100 - at_0), 0, 27648))


class Plant:
    """Values by name, with the start values of the table. `restart` shows what it starts with, `call` is one CYCLE."""

    STARTS = {}

    def __init__(self):
        self.values = dict(self.STARTS)

    def __getattr__(self, name):
        try:
            return self.__dict__["values"][name]
        except KeyError:
            raise AttributeError(name) from None

    def set(self, name, value):
        if name not in self.STARTS:
            raise KeyError(f"{type(self).__name__} has no {name}")
        # A plant computes in 64 bits, whatever the controller's output has.
        self.values[name] = value.item() if isinstance(value, np.generic) else value

    def get(self, name):
        return self.values[name]

    def show(self, **outputs):
        self.values.update(outputs)


class HEATER(Plant):
    STARTS = {
        **{"POWER": 0.0, "DOOR": 0.0, "T_AMB": 20.0, "T_START": 20.0, "RISE": 300.0, "FURN_TM": 120.0, "SENS_TM": 20.0},
        **{"DELAY_TM": 5.0, "DOOR_LOSS": 50.0, "T_PER_0": 0.0, "T_PER_100": 400.0, "CYCLE": 0.1},
        **{"TEMP": 20.0, "T_PER": 0, "T_FURN": 20.0},
    }

    def restart(self):
        held = limited(100 * (self.T_START - self.T_AMB) / self.RISE, 0, 100)
        calls = self.DELAY_TM / self.CYCLE
        assert calls == round(calls), "a dead time of whole calls"
        self.on_the_way = [held] * round(calls)
        self.shown(self.T_START, self.T_START)

    def call(self):
        self.on_the_way.append(limited(self.POWER, 0, 100))
        power = self.on_the_way.pop(0)
        loss = 1 + limited(self.DOOR, 0, 100) / 100 * self.DOOR_LOSS / 100

        def slope(x):
            furnace = (self.RISE * power / 100 - loss * (x[0] - self.T_AMB)) / self.FURN_TM
            return [furnace, (x[0] - x[1]) / self.SENS_TM]

        self.shown(*integrated(slope, [self.T_FURN, self.TEMP], self.CYCLE, STEPS))

    def shown(self, furnace, sensor):
        self.show(T_FURN=furnace, TEMP=sensor, T_PER=analog(sensor, self.T_PER_0, self.T_PER_100))


class VALVE(Plant):
    """Without backlash and without sticking."""

    STARTS = {
        **{"UP": False, "DOWN": False, "DRIVE": 0.0, "PRES": 4.0, "T_IN": 20.0, "POS_ON": False, "MTR_TM": 30.0},
        **{"POS_START": 0.0, "T_START": 20.0, "CURVE": 1.0, "FLOW_MAX": 40.0, "PRES_NOM": 4.0, "RISE": 80.0},
        **{"HX_TM": 20.0, "SENS_TM": 5.0, "T_PER_0": 0.0, "T_PER_100": 100.0, "CYCLE": 0.1},
        **{"LMNR": 0.0, "LMNR_HS": False, "LMNR_LS": True, "FLOW": 0.0, "TEMP": 20.0, "T_PER": 0, "T_HX": 20.0},
    }

    def restart(self):
        self.shown([self.T_START, self.T_START], self.POS_START)

    def call(self):
        speed = limited(100 * bool(self.UP) - 100 * bool(self.DOWN) + self.DRIVE, -100, 100) / self.MTR_TM
        end = limited(self.LMNR + speed * self.CYCLE, 0, 100)
        moving = self.CYCLE if speed == 0 else (end - self.LMNR) / speed
        state = self.moved([self.T_HX, self.TEMP], self.LMNR, end, moving)
        self.shown(self.moved(state, end, end, self.CYCLE - moving), end)

    def moved(self, state, begin, end, seconds):
        """The temperatures after the stem has gone from one position to another one, evenly."""
        if seconds <= 0:
            return state
        pressure = math.sqrt(self.PRES / self.PRES_NOM)

        def slope(x):
            stem = (begin + (end - begin) * x[2] / seconds) / 100
            share = stem if self.CURVE == 1 else (self.CURVE**stem - 1) / (self.CURVE - 1)
            exchanger = (self.T_IN + self.RISE * share * pressure - x[0]) / self.HX_TM
            return [exchanger, (x[0] - x[1]) / self.SENS_TM, 1]

        return integrated(slope, [*state, 0.0], seconds, STEPS)[:2]

    def shown(self, temperatures, stem):
        exchanger, sensor = temperatures
        self.show(LMNR=stem, LMNR_HS=stem >= 100, LMNR_LS=stem <= 0, T_HX=exchanger, TEMP=sensor)
        self.show(T_PER=analog(sensor, self.T_PER_0, self.T_PER_100))


class TANK(Plant):
    STARTS = {
        **{"VALVE": 0.0, "DRAIN": 50.0, "L_START": 0.5, "HEIGHT": 2.0, "AREA": 0.2, "FLOW_MAX": 100.0, "A_OUT": 0.0004},
        **{"CD": 0.6, "L_PER_0": 0.0, "L_PER_100": 2.0, "CYCLE": 0.1, "LEVEL": 0.5, "L_PER": 0},
    }

    def restart(self):
        self.shown(self.L_START)

    def call(self):
        inflow = self.FLOW_MAX * LITRE_PER_MINUTE * limited(self.VALVE, 0, 100) / 100
        opening = self.CD * self.A_OUT * limited(self.DRAIN, 0, 100) / 100

        def slope(x):
            return [(inflow - opening * math.sqrt(2 * G * max(x[0], 0))) / self.AREA]

        (level,) = integrated(slope, [self.LEVEL], self.CYCLE, STEPS)
        self.shown(limited(level, 0, self.HEIGHT))

    def shown(self, level):
        self.show(LEVEL=level, L_PER=analog(level, self.L_PER_0, self.L_PER_100))


class THERMO(Plant):
    STARTS = {
        **{"HEAT": False, "COOL": False, "DRIVE": 0.0, "T_AMB": 20.0, "LOAD": 0.0, "T_START": 20.0, "RISE": 60.0},
        **{"DROP": 120.0, "HEAT_TM": 10.0, "COOL_TM": 15.0, "ZONE_TM": 100.0, "T_PER_0": -100.0, "T_PER_100": 100.0},
        **{"CYCLE": 0.01, "TEMP": 20.0, "T_PER": 0, "HEATING": 0.0, "COOLING": 0.0},
    }

    def restart(self):
        self.shown(0.0, 0.0, self.T_START)

    def call(self):
        heat = limited(100 * bool(self.HEAT) + max(self.DRIVE, 0), 0, 100)
        cool = limited(100 * bool(self.COOL) - min(self.DRIVE, 0), 0, 100)

        def slope(x):
            target = self.T_AMB + self.LOAD + self.RISE * x[0] / 100 - self.DROP * x[1] / 100
            return [(heat - x[0]) / self.HEAT_TM, (cool - x[1]) / self.COOL_TM, (target - x[2]) / self.ZONE_TM]

        self.shown(*integrated(slope, [self.HEATING, self.COOLING, self.TEMP], self.CYCLE, STEPS))

    def shown(self, heating, cooling, temperature):
        self.show(HEATING=heating, COOLING=cooling, TEMP=temperature)
        self.show(T_PER=analog(temperature, self.T_PER_0, self.T_PER_100))


class DRIVE(Plant):
    STARTS = {
        **{"SP": 0, "RESET": False, "LOAD": 0.0, "N_MAX": 1500.0, "CTRL_TM": 0.1, "ACC_TM": 2.0, "M_MAX": 150.0},
        **{"ERR_MAX": 75.0, "COAST_TM": 2.0, "CYCLE": 0.01},
        **{"SPEED": 0.0, "N_ACT": 0, "TRIP": False, "SP_RPM": 0.0, "TORQUE": 0.0},
    }

    def restart(self):
        self.was_reset = False

    def call(self):
        target = self.N_MAX * self.SP / 32767
        starts_again, self.was_reset = self.RESET and not self.was_reset, self.RESET
        is_tripped = (self.TRIP and not starts_again) or abs(target - self.SPEED) > self.ERR_MAX
        load = limited(self.LOAD, -self.M_MAX, self.M_MAX)
        percent = abs(self.N_MAX) / self.ACC_TM / 100

        def slope(x):
            if is_tripped:
                return [-x[0] / self.COAST_TM]
            return [limited((target - x[0]) / self.CTRL_TM, percent * (-self.M_MAX - load), percent * (self.M_MAX - load))]

        (speed,) = integrated(slope, [self.SPEED], self.CYCLE, STEPS)
        torque = 0.0 if is_tripped else load + slope([speed])[0] / percent
        counts = 32767 * speed / self.N_MAX
        self.show(SP_RPM=target, TRIP=is_tripped, SPEED=speed, TORQUE=torque, N_ACT=int(counts + math.copysign(0.5, counts)))


PLANTS = {plant.__name__: plant for plant in Plant.__subclasses__()}


def flat(table, prefix=""):
    """The values of a table in tables, by their names with dots."""
    values = {}
    for name, value in table.items():
        values.update(flat(value, f"{prefix}{name}.") if isinstance(value, dict) else {prefix + name: value})
    return values


def set_value(member, name, value):
    """Sets a variable of a block, whose times are in milliseconds there, or of a plant."""
    if isinstance(member, oracle.Block):
        block, terminal = member.owner_of(name)
        if block.INPUTS[terminal][0] is oracle.TIME:
            value = round(value * 1000)
    member.set(name, value)


def simulated(tables, record):
    """Runs the description of a loop, read by tomllib: the variables of `record`, by name, a value of each call. Those of plants are the
    ones after it."""
    members = {name: {**oracle.BLOCKS, **PLANTS}[fmu.removesuffix(".fmu")]() for name, fmu in tables["fmus"].items()}

    def owner(name):
        member, variable = name.split(".", 1)
        return members[member], variable

    def get(name):
        member, variable = owner(name)
        return member.get(variable)

    def put(to, value):
        member, variable = owner(to)
        member.set(variable, value)

    for name, value in flat(tables.get("settings", {})).items():
        set_value(*owner(name), value)
    connected = flat(tables["connections"]).items()
    wires = [(source, to) for source, many in connected for to in (many if isinstance(many, list) else [many])]
    for member in members.values():
        member.restart()
    step, exchange = tables["step"], tables.get("exchange", "sequential")
    events = sorted(tables.get("events", []), key=lambda event: event["time"])
    rows = {name: [] for name in record}
    for call in range(round(tables["stop"] / step)):
        while events and events[0]["time"] < (call + 0.5) * step:
            for name, value in flat(events.pop(0)["set"]).items():
                set_value(*owner(name), value)
        if exchange == "parallel":
            for (_, to), value in zip(wires, [get(source) for source, _ in wires]):
                put(to, value)
            # A row has the outputs that the others read in its call.
            for name in record:
                rows[name].append(get(name))
        for member in members.values():
            if exchange == "sequential":
                for source, to in wires:
                    if owner(to)[0] is member:
                        put(to, get(source))
            member.call()
        if exchange == "sequential":
            for name in record:
                rows[name].append(get(name))
    return rows
