"""The plants against their documented equations.

Each plant is held to its steady state, its time constants and, where it moves, to a numerical integration of
the differential equations of its documentation, which shares nothing with the plant's own closed solution.
"""

import math
import random

import pytest
from second_plants import G, LITRE_PER_MINUTE, analog, integrated


def close(*numbers, abs=1e-6):
    return pytest.approx(numbers if len(numbers) > 1 else numbers[0], rel=1e-7, abs=abs)


@pytest.fixture
def heater(open_fmu):
    return lambda **values: open_fmu("HEATER").start(**{"CYCLE": 1.0, **values})


@pytest.fixture
def valve(open_fmu):
    return lambda **values: open_fmu("VALVE").start(**values)


@pytest.fixture
def thermo(open_fmu):
    return lambda **values: open_fmu("THERMO").start(**{"CYCLE": 0.1, **values})


@pytest.fixture
def tank(open_fmu):
    return lambda **values: open_fmu("TANK").start(**{"CYCLE": 1.0, **values})


@pytest.fixture
def drive(open_fmu):
    return lambda **values: open_fmu("DRIVE").start(**values)


@pytest.fixture
def process(open_fmu):
    return lambda **values: open_fmu("PROCESS").start(**values)


@pytest.fixture
def sensor(open_fmu):
    return lambda **values: open_fmu("SENSOR").start(**{"NOISE": 0.0, "STEPS": 0, **values})


@pytest.mark.parametrize("name", ["HEATER", "VALVE", "THERMO", "TANK", "PROCESS"])
def test_the_result_does_not_depend_on_the_cycle(open_fmu, name):
    """Solved exactly for held inputs: a step of a second in one call or in a hundred."""
    ends = []
    for cycle in (1.0, 0.01):
        fmu = open_fmu(name)
        plant = fmu.start(CYCLE=cycle)
        generator = random.Random(name)
        for _ in range(60):
            for variable in fmu.of("input", type="Real"):
                v = fmu.variables[variable]
                low, high = float(v.min or -10), float(v.max or 10)
                plant.set(**{variable: generator.uniform(max(low, -100), high)})
            plant.step(1.0)
        ends.append(plant.get(fmu.of("output", type="Real")))
    for variable, value in ends[0].items():
        assert value == close(ends[1][variable], abs=1e-8), variable


# --- HEATER ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("power", [0.0, 25.0, 60.0, 100.0])
@pytest.mark.parametrize("door", [0.0, 50.0, 100.0])
def test_heater_holds_rise_times_power_divided_by_the_loss(heater, power, door):
    """RISE 300 K, DOOR_LOSS 50 %, T_AMB 20 degC."""
    furnace = heater(POWER=power, DOOR=door)
    furnace.step(10_000.0)
    expected = 20 + 300 * power / 100 / (1 + door / 100 * 0.5)
    assert [furnace["TEMP"], furnace["T_FURN"]] == close(expected, expected)


def test_heater_gives_off_the_power_that_it_takes_up(heater):
    """The loss at rest is (TEMP - T_AMB) L, in units of what full power holds."""
    furnace = heater(POWER=37.0, DOOR=80.0, T_AMB=5.0, RISE=410.0, DOOR_LOSS=70.0)
    furnace.step(10_000.0)
    loss = (furnace["TEMP"] - 5.0) * (1 + 0.8 * 0.7)
    assert loss == close(0.37 * 410.0)


def test_heater_answers_after_its_delay_and_not_before(heater):
    furnace = heater(POWER=100.0, DELAY_TM=5.0)
    assert furnace.record("T_FURN", calls=5) == [20.0] * 5
    furnace.step()
    assert furnace["T_FURN"] == close(20 + 300 * (1 - math.exp(-1 / 120)))


def test_heater_reaches_63_percent_in_its_time_constant(heater):
    furnace = heater(POWER=100.0, DELAY_TM=0.0, SENS_TM=0.0)
    furnace.step(120.0)
    expected = 20 + 300 * (1 - math.exp(-1))
    assert [furnace["T_FURN"], furnace["TEMP"]] == close(expected, expected)


def test_heater_sensor_follows_the_furnace_as_a_second_lag(heater):
    furnace = heater(POWER=100.0, DELAY_TM=0.0)
    furnace.step(100.0)
    expected = 1 - (120 * math.exp(-100 / 120) - 20 * math.exp(-100 / 20)) / (120 - 20)
    assert furnace["TEMP"] == close(20 + 300 * expected)


def test_heater_follows_its_differential_equations(heater):
    """Power and door change every second; the delay of 5 s is a queue of five."""
    generator = random.Random(1)
    furnace = heater(DELAY_TM=5.0)
    state = [20.0, 20.0]
    queue = [0.0] * 5
    for _ in range(300):
        power, door, t_amb = generator.uniform(0, 100), generator.uniform(0, 100), generator.uniform(-10, 30)
        furnace.step(1.0, POWER=power, DOOR=door, T_AMB=t_amb)
        queue.append(power)
        p = queue.pop(0)
        loss = 1 + door / 100 * 0.5

        def slope(x):
            return [(300 * p / 100 - loss * (x[0] - t_amb)) / 120, (x[0] - x[1]) / 20]

        state = integrated(slope, state, 1.0, 10)
        assert [furnace["T_FURN"], furnace["TEMP"]] == close(*state)


def test_heater_starts_warm_at_rest(heater):
    """170 degC is held by 50 %, which is still on its way; the power set acts after the delay."""
    furnace = heater(T_START=170.0, POWER=0.0)
    assert furnace.record("TEMP", calls=5) == [close(170.0)] * 5
    assert furnace.record("T_FURN", calls=1)[0] < 169.0


@pytest.mark.parametrize("t", [-10.0, 0.0, 123.4, 200.0, 399.99, 400.0, 500.0])
def test_heater_analog_value(heater, t):
    assert heater(T_START=t)["T_PER"] == analog(t, 0, 400)


def test_heater_analog_value_makes_degrees_again_in_cont_c(heater, open_fmu):
    """PV_FAC = 4, PV_OFF = 0 for 0 ... 400 degC, to half a count of 0.0145 K."""
    controller = open_fmu("CONT_C").start(PVPER_ON=1, PV_FAC=4.0)
    for t in (20.0, 123.4, 300.0):
        controller.step(PV_PER=heater(T_START=t)["T_PER"])
        assert controller["PV"] == pytest.approx(t, abs=400 / 27648 / 2 + 1e-4)


def test_heater_limits_power_and_door(heater):
    limited, beyond = heater(POWER=100.0, DOOR=0.0), heater(POWER=250.0, DOOR=-50.0)
    limited.step(60.0)
    beyond.step(60.0)
    assert limited["TEMP"] == beyond["TEMP"]


# --- VALVE ----------------------------------------------------------------------------------------------


def test_valve_takes_mtr_tm_from_stop_to_stop_and_reports_the_stops(valve):
    v = valve(UP=1)
    assert (v["LMNR"], v["LMNR_LS"], v["LMNR_HS"]) == (0.0, 1, 0)
    v.step(15.0)
    assert (v["LMNR"], v["LMNR_LS"], v["LMNR_HS"]) == (close(50.0), 0, 0)
    v.step(14.9)
    assert v["LMNR_HS"] == 0
    v.step(0.1)
    assert (v["LMNR"], v["LMNR_LS"], v["LMNR_HS"]) == (100.0, 0, 1)
    v.set(UP=0, DOWN=1)
    v.step(30.0)
    assert (v["LMNR"], v["LMNR_LS"], v["LMNR_HS"]) == (0.0, 1, 0)


def test_valve_stands_without_pulses_and_with_both(valve):
    v = valve(POS_START=40.0)
    v.step(10.0)
    assert v["LMNR"] == 40.0
    v.step(10.0, UP=1, DOWN=1)
    assert v["LMNR"] == 40.0


def test_valve_drive_is_a_speed_in_percent(valve):
    """30 % of full speed for 20 s: 20 %; as pulses that are on for 30 % of the time."""
    smooth, pulsed = valve(DRIVE=30.0), valve()
    smooth.step(20.0)
    for call in range(200):
        pulsed.step(0.1, UP=int(call % 10 < 3))
    assert [smooth["LMNR"], pulsed["LMNR"]] == close(20.0, 20.0)


def test_valve_backlash_is_idle_travel_after_a_reversal(valve):
    """10 % backlash are 3 s of the motor's 30 s."""
    v = valve(BACKLASH=10.0, POS_START=50.0, UP=1)
    positions = []
    for up, down in ((1, 0), (1, 0), (0, 1), (0, 1), (0, 1), (1, 0), (1, 0)):
        v.step(3.0, UP=up, DOWN=down)
        positions.append(v["LMNR"])
    assert positions == close(50.0, 60.0, 60.0, 50.0, 40.0, 40.0, 50.0)


def test_valve_stuck_does_not_move(valve):
    v = valve(POS_START=50.0, UP=1)
    v.step(3.0, STUCK=1)
    assert v["LMNR"] == 50.0
    v.step(3.0, STUCK=0)
    assert v["LMNR"] == close(60.0)


def test_valve_with_positioner_goes_to_the_position_asked_for(valve):
    v = valve(POS_ON=1, BACKLASH=10.0)
    v.step(60.0, DRIVE=70.0)
    assert v["LMNR"] == 70.0
    v.step(60.0, DRIVE=20.0)
    assert v["LMNR"] == 20.0


@pytest.mark.parametrize("curve", [0.2, 1.0, 30.0, 50.0])
@pytest.mark.parametrize("position", [0.0, 25.0, 50.0, 100.0])
def test_valve_characteristic(valve, curve, position):
    v = valve(CURVE=curve, POS_START=position)
    v.step()
    x = position / 100
    share = x if curve == 1 else (curve**x - 1) / (curve - 1)
    assert v["FLOW"] == close(40 * share)


def test_valve_flow_follows_the_root_of_the_pressure(valve):
    v = valve(POS_START=100.0)
    flows = []
    for pressure in (0.0, 1.0, 4.0, 9.0):
        v.step(PRES=pressure)
        flows.append(v["FLOW"])
    assert flows == close(0.0, 20.0, 40.0, 60.0)


@pytest.mark.parametrize("position, pressure, t_in", [(0.0, 4.0, 20.0), (50.0, 4.0, 20.0), (75.0, 1.0, 5.0)])
def test_valve_steady_state_is_t_in_plus_rise_times_flow(valve, position, pressure, t_in):
    v = valve(POS_START=position, PRES=pressure, T_IN=t_in)
    v.step(1000.0)
    expected = t_in + 80 * position / 100 * math.sqrt(pressure / 4)
    assert [v["TEMP"], v["T_HX"]] == close(expected, expected)


def test_valve_follows_its_differential_equations_while_it_moves(valve):
    """Equal percentage characteristic, the stem runs for 20 s from 10 % on, then stands."""
    v = valve(CURVE=30.0, POS_START=10.0, PRES=3.0)
    state = [20.0, 20.0, 10.0]
    for second in range(40):
        moving = second < 20
        v.step(1.0, UP=int(moving))

        def slope(x):
            position = x[2] / 100
            share = (30**position - 1) / 29 * math.sqrt(3 / 4)
            return [(20 + 80 * share - x[0]) / 20, (x[0] - x[1]) / 5, 100 / 30 if moving else 0]

        state = integrated(slope, state, 1.0, 50)
        assert [v["T_HX"], v["TEMP"], v["LMNR"]] == close(*state)


def test_valve_moves_as_cont_s_pulses(valve, open_fmu):
    """100 CYCLE / MTR_TM percent for each call with a pulse."""
    controller = open_fmu("CONT_S").start(CYCLE=0.1, PULSE_TM=0.3, BREAK_TM=0.3, SP_INT=8.0)
    v = valve(POS_START=20.0)
    pulses = 0
    for _ in range(600):
        controller.step()
        up, down = controller["QLMNUP"], controller["QLMNDN"]
        pulses += up - down
        v.step(0.1, UP=up, DOWN=down)
    assert pulses > 30
    assert v["LMNR"] == close(20 + pulses * 100 * 0.1 / 30)


# --- THERMO ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("drive", [-100.0, -40.0, 0.0, 40.0, 100.0])
@pytest.mark.parametrize("t_amb, load", [(20.0, 0.0), (35.0, 4.0)])
def test_thermo_steady_state(thermo, drive, t_amb, load):
    """RISE 60 K at full heating, DROP 120 K at full cooling."""
    chamber = thermo(DRIVE=drive, T_AMB=t_amb, LOAD=load)
    chamber.step(5000.0)
    assert chamber["TEMP"] == close(t_amb + load + (0.6 if drive > 0 else 1.2) * drive)


def test_thermo_time_constants_of_heating_and_cooling_differ(thermo):
    """HEAT_TM 10 s, COOL_TM 15 s."""
    heating, cooling = thermo(HEAT=1), thermo(COOL=1)
    heating.step(10.0)
    cooling.step(15.0)
    share = 100 * (1 - math.exp(-1))
    assert [heating["HEATING"], cooling["COOLING"]] == close(share, share)
    assert heating["COOLING"] == cooling["HEATING"] == 0.0


def test_thermo_follows_its_differential_equations(thermo):
    generator = random.Random(2)
    chamber = thermo()
    state = [0.0, 0.0, 20.0]
    for _ in range(200):
        heat, cool = generator.randint(0, 1), generator.randint(0, 1)
        drive, t_amb, load = generator.uniform(-50, 50), generator.uniform(0, 30), generator.uniform(-5, 5)
        chamber.step(1.0, HEAT=heat, COOL=cool, DRIVE=drive, T_AMB=t_amb, LOAD=load)
        h = min(100, 100 * heat + max(drive, 0))
        c = min(100, 100 * cool - min(drive, 0))

        def slope(x):
            target = t_amb + load + 60 * x[0] / 100 - 120 * x[1] / 100
            return [(h - x[0]) / 10, (c - x[1]) / 15, (target - x[2]) / 100]

        state = integrated(slope, state, 1.0, 10)
        assert [chamber["HEATING"], chamber["COOLING"], chamber["TEMP"]] == close(*state)


def test_thermo_feels_the_mean_of_short_pulses(thermo):
    """30 % of a period of 1 s, and DRIVE 30 %."""
    pulsed, smooth = thermo(), thermo(DRIVE=30.0)
    for call in range(6000):
        pulsed.step(0.1, HEAT=int(call % 10 < 3))
    smooth.step(600.0)
    assert pulsed["TEMP"] == pytest.approx(smooth["TEMP"], abs=0.05)


@pytest.mark.parametrize("t", [-120.0, -100.0, 20.0, 99.99, 130.0])
def test_thermo_analog_value(thermo, t):
    assert thermo(T_START=t)["T_PER"] == analog(t, -100, 100)


# --- TANK -------------------------------------------------------------------------------------------------


def outflow(level, drain):
    """CD 0.6, A_OUT 0.0004 m2, in m3/s."""
    return 0.6 * 0.0004 * drain / 100 * math.sqrt(2 * G * max(level, 0))


def test_tank_steady_level(tank):
    """Where inflow and outflow are equal: 31.9 l/min hold 1 m with the drain half open."""
    flow = outflow(1.0, 50.0) / LITRE_PER_MINUTE
    assert flow == pytest.approx(31.9, abs=0.05)
    t = tank(VALVE=flow)
    t.step(20_000.0)
    assert t["LEVEL"] == close(1.0)
    assert [t["INFLOW"], t["OUTFLOW"]] == close(flow, flow)


def test_tank_keeps_its_volume(tank):
    """AREA times the change of level is what came in less what went out."""
    t = tank(CYCLE=0.01, VALVE=60.0)
    volume = 0.0
    flows = t.record("INFLOW", "OUTFLOW", calls=20_000)
    for (_, before), (inflow, after) in zip([(0, outflow(0.5, 50) / LITRE_PER_MINUTE)] + flows, flows):
        volume += (inflow - (before + after) / 2) * LITRE_PER_MINUTE * 0.01
    assert 0.2 * (t["LEVEL"] - 0.5) == pytest.approx(volume, rel=1e-6)
    assert t["LEVEL"] > 0.8


def test_tank_follows_its_differential_equation(tank):
    generator = random.Random(3)
    t = tank()
    state = [0.5]
    for _ in range(200):
        position, drain = generator.uniform(20, 60), generator.uniform(20, 80)
        t.step(1.0, VALVE=position, DRAIN=drain)
        inflow = 100 * LITRE_PER_MINUTE * position / 100
        state = integrated(lambda x: [(inflow - outflow(x[0], drain)) / 0.2], state, 1.0, 10)
        assert t["LEVEL"] == close(state[0], abs=1e-9)


def test_tank_runs_empty_in_finite_time(tank):
    """Torricelli: AREA / (CD A) sqrt(2 LEVEL / g), 532 s here."""
    time = 0.2 / (0.6 * 0.0002) * math.sqrt(2 * 0.5 / G)
    t = tank(CYCLE=0.1)
    t.step(time / 2)
    assert t["LEVEL"] == pytest.approx(0.125, rel=1e-3)  # the root falls evenly
    t.step(time * 0.495)
    assert t["LEVEL"] > 0
    t.step(time * 0.01)
    assert (t["LEVEL"], t["OUTFLOW"]) == (0.0, 0.0)


def test_tank_overflows_at_its_height(tank):
    t = tank(VALVE=100.0, L_START=1.9)
    assert t["FULL"] == 0
    t.step(2000.0)
    assert (t["LEVEL"], t["FULL"]) == (close(2.0), 1)
    t.step(1.0, VALVE=0.0)
    assert t["FULL"] == 0
    assert t["LEVEL"] < 2.0


@pytest.mark.parametrize("level", [0.0, 0.37, 1.0, 2.0])
def test_tank_analog_value(tank, level):
    assert tank(L_START=level)["L_PER"] == analog(level, 0, 2)


# --- DRIVE -------------------------------------------------------------------------------------------------

RPM = 1500 / 32767  # a count


def test_drive_follows_a_small_step_as_a_lag(drive):
    """CTRL_TM 0.1 s; 1000 counts are 45.8 rpm."""
    d = drive(SP=1000)
    speeds = d.record("SPEED", calls=50)
    for call, speed in enumerate(speeds, 1):
        assert speed == close(1000 * RPM * (1 - math.exp(-call * 0.01 / 0.1)))


def test_drive_accelerates_no_faster_than_its_torque_allows(drive):
    """150 % of the torque that takes it from 0 to 1500 rpm in 2 s: 1125 rpm a second, with 50 % load 750."""
    for load, acceleration in ((0.0, 1125.0), (50.0, 750.0)):
        d = drive(SP=32767, ERR_MAX=1e6, LOAD=load)
        speeds = d.record("SPEED", calls=50)
        assert speeds == close(*[acceleration * 0.01 * call for call in range(1, 51)])
        assert d["TORQUE"] == close(150.0)


def test_drive_torque_at_rest_is_the_load(drive):
    d = drive(LOAD=30.0, SP=1000)
    d.step(10.0)
    assert d["TORQUE"] == close(30.0)
    assert d["SPEED"] == close(1000 * RPM)


def test_drive_stays_behind_a_ramp_by_its_time_constant(drive):
    """Counts by 100 a call: 457.8 rpm a second, 45.8 rpm behind, less what the held setpoint leads."""
    d = drive()
    rate = 100 * RPM / 0.01
    d.record("SPEED", calls=200, SP=[100 * call for call in range(200)])
    assert d["SP_RPM"] - d["SPEED"] == pytest.approx(rate * 0.1, rel=0.1)


@pytest.mark.parametrize("jump, trip", [(1638, 0), (1639, 1), (-1638, 0), (-1639, 1)])
def test_drive_trips_where_the_setpoint_jumps_by_more_than_err_max(drive, jump, trip):
    """75 rpm are 1638.35 counts."""
    d = drive(SP=jump)
    d.step()
    assert d["TRIP"] == trip


def test_drive_tripped_coasts_without_torque(drive):
    d = drive(SP=1600)
    d.step(5.0)
    speed = d["SPEED"]
    d.step(2.0, SP=20_000)
    assert (d["TRIP"], d["TORQUE"]) == (1, 0.0)
    assert d["SPEED"] == close(speed * math.exp(-2.0 / 2.0))


def test_drive_goes_on_at_a_rising_edge_of_reset_alone(drive):
    d = drive(SP=20_000, RESET=1)
    d.step()
    assert d["TRIP"] == 1
    d.set(SP=0)
    assert d.record("TRIP", calls=4, RESET=[1, 0, 1, 1]) == [1, 1, 0, 0]


def test_drive_actual_value_in_counts(drive):
    d = drive(SP=-1600)
    d.step(5.0)
    assert d["N_ACT"] == -1600


def test_hlg_brings_the_drive_to_its_speed_and_a_jump_does_not(drive, open_fmu):
    """S1 = 20000 in 4 s: 229 rpm a second. Without the ramp the same setpoint trips it."""
    for th, tripped in ((400, 0), (100, 1), (0, 1)):
        ramp = open_fmu("HLG").start(E01=1, S1=20_000, TH_TZ=th)
        d = drive()
        for _ in range(600):
            ramp.step()
            d.step(SP=ramp["HLG"])
        assert d["TRIP"] == tripped
        assert (d["SPEED"] == pytest.approx(20_000 * RPM, abs=0.5)) is not bool(tripped)


# --- PROCESS -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("u, load", [(0.0, 0.0), (30.0, 0.0), (30.0, -10.0), (-100.0, 5.0)])
def test_process_steady_state_is_gain_times_the_way_from_the_operating_point(process, u, load):
    p = process(U=u, LOAD=load, GAIN=1.5, T2=3.0, PV_0=20.0, U_0=10.0)
    p.step(1000.0)
    assert p["PV"] == close(20 + 1.5 * (u + load - 10))


def test_process_reaches_63_percent_after_dead_time_and_time_constant(process):
    """DEAD_TM 1 s and T1 10 s."""
    p = process(U=100.0)
    p.step(11.0)
    assert p["PV"] == close(100 * (1 - math.exp(-1)))


@pytest.mark.parametrize("integ", [0, 1])
def test_process_waits_for_the_calls_of_its_dead_time(process, integ):
    """1 s of 0.1 s: ten calls without effect."""
    p = process(U=50.0, INTEG=integ)
    assert p.record("PV", calls=10) == [0.0] * 10
    p.step(0.1)
    assert p["PV"] > 0


def test_process_integrating_rises_by_gain_a_second_and_rests_at_u_0(process):
    p = process(INTEG=1, GAIN=0.1, T1=0.0, DEAD_TM=0.0, U_0=40.0, U=50.0, PV_0=5.0)
    p.step(30.0)
    assert p["PV"] == close(35.0)
    p.step(30.0, U=40.0)
    assert p["PV"] == close(35.0)


@pytest.mark.parametrize("integ", [0, 1])
def test_process_follows_its_differential_equations(process, integ):
    """U and LOAD change every second; the dead time of 3 s is a queue of three."""
    generator = random.Random(4)
    p = process(INTEG=integ, GAIN=0.7, T1=6.0, T2=2.0, DEAD_TM=3.0, PV_0=9.0, U_0=20.0)
    state = [0.0, 0.0, 9.0]
    queue = [20.0] * 3
    for _ in range(200):
        u, load = generator.uniform(-100, 100), generator.uniform(-20, 20)
        p.step(1.0, U=u, LOAD=load)
        queue.append(u + load)
        delayed = queue.pop(0)

        def slope(x):
            return [(0.7 * (delayed - 20) - x[0]) / 6, (x[0] - x[1]) / 2, x[1]]

        state = integrated(slope, state, 1.0, 50)
        assert p["PV"] == close(state[2] if integ else 9 + state[1])


@pytest.mark.parametrize("pv", [-30.0, -20.0, 0.0, 33.3, 80.0, 90.0])
def test_process_analog_value(process, pv):
    assert process(PV_0=pv, PV_PER_0=-20.0, PV_PER_100=80.0)["PV_PER"] == analog(pv, -20, 80)


# --- SENSOR ------------------------------------------------------------------------------------------------


def gaussian(call, seed):
    """The noise of its documentation, in Python: twelve numbers of 16 bits from SplitMix64."""
    total = 0
    for part in range(3):
        bits = (seed % 2**16 * 0xD1B54A32D192ED03 + (3 * call + part + 1) * 0x9E3779B97F4A7C15) % 2**64
        bits = (bits ^ bits >> 30) * 0xBF58476D1CE4E5B9 % 2**64
        bits = (bits ^ bits >> 27) * 0x94D049BB133111EB % 2**64
        bits ^= bits >> 31
        total += sum(bits >> place & 0xFFFF for place in (0, 16, 32, 48))
    return (total - 12 * 65535 / 2) / math.sqrt(65536**2 - 1)


@pytest.mark.parametrize("seed", [-1, 0, 1, 32767])
def test_sensor_noise_is_that_of_its_formula_to_the_last_bit(sensor, seed):
    s = sensor(NOISE=1.0, SEED=seed)
    assert s.record("Y", calls=200) == [gaussian(call, seed) for call in range(200)]


def test_sensor_noise_has_its_standard_deviation(sensor):
    values = sensor(NOISE=0.5, U=50.0).record("Y", calls=20_000)
    mean = sum(values) / len(values)
    assert mean == pytest.approx(50, abs=0.02)
    assert math.sqrt(sum((value - mean) ** 2 for value in values) / len(values)) == pytest.approx(0.5, rel=0.02)


def test_sensor_filter_is_a_lag_from_the_first_value_on(sensor):
    s = sensor(LAG_TM=2.0, U=10.0)
    s.step(0.1)
    assert s["Y"] == 10.0
    s.step(2.0, U=20.0)
    assert s["Y"] == close(20 - 10 * math.exp(-1))


@pytest.mark.parametrize("u", [-1.0, 0.0, 12.34, 50.1, 99.99, 101.0])
@pytest.mark.parametrize("steps", [27648, 4096, 100])
def test_sensor_resolution(sensor, u, steps):
    s = sensor(U=u, STEPS=steps)
    s.step(0.1)
    assert s["Y"] == close(round(min(max(u, 0), 100) / 100 * steps) * 100 / steps)
    assert s["Y_PER"] == analog(s["Y"], 0, 100)


def test_sensor_noise_moves_a_controller_by_its_gain_and_by_its_derivative(sensor, open_fmu):
    """The numbers of its quick start: GAIN 5 makes 0.5 of 0.1; with TD 2 s and TM_LAG 0.2 s LMN_D varies by 4.5."""
    controller = open_fmu("CONT_C").start(MAN_ON=0, I_SEL=0, D_SEL=1, GAIN=5.0, TD=2.0, TM_LAG=0.2, CYCLE=0.1, LMN_LLM=-100.0)
    s = sensor(NOISE=0.1)
    parts = []
    for _ in range(20_000):
        s.step(0.1)
        controller.step(0.1, PV_IN=s["Y"])
        parts.append((controller["LMN_P"], controller["LMN_D"]))
    p, d = (math.sqrt(sum(value**2 for value in part) / len(part)) for part in zip(*parts))
    assert [p, d] == [pytest.approx(0.5, rel=0.03), pytest.approx(4.47, rel=0.03)]
