"""Random runs of every controller against oracle.py, the second version of the laws, bit for bit.

PLCFMU_RANDOM is a factor on the 20 runs of each block. A run has CALLS calls; its seed stands in the
test's name: `pytest "test_random.py::test_a_random_run_equals_the_second_text_of_the_law[CONT_C-7]"`
repeats one.
"""

import os
import random

import numpy as np
import pytest

import host
import oracle
from oracle import BOOL, REAL, TIME, WORD

RUNS = round(20 * float(os.environ.get("PLCFMU_RANDOM", "1")))
CALLS = 500

# How often a BOOL is TRUE, where a coin would keep the block from working.
OFTEN = {
    **dict.fromkeys(["COM_RST", "STOP", "SET", "R"], 0.02),
    **dict.fromkeys(["MAN_ON", "INT_HOLD", "I_ITL_ON", "LMNS_ON", "LMNR_HS", "LMNR_LS", "PVPER_ON"], 0.15),
    **dict.fromkeys(["P_SEL", "I_SEL"], 0.85),
}
ODD_REALS = [
    0.0,
    -0.0,
    1e-45,
    -1e-38,
    1e-3,
    3.4028234e38,
    -3.4028234e38,
    1e30,
    -1e30,
    1e10,
    7766000.0,
    16777217.0,
]
ODD_TIMES = [0, 1, 2, 49, 50, 999, 2**31 - 1, 2**31 - 2, 2**24 + 1, 10**9]
ODD_INTS = [0, 1, -1, 2, -2, 32767, -32767, -32768, 27648, -27648]


class Draw:
    """Values for terminals: such as a plant has, and in some runs odd ones among them."""

    def __init__(self, generator, cycle):
        self.generator = generator
        self.cycle = cycle
        self.odd = generator.choice([0.0, 0.0, 0.01, 0.05])

    def __call__(self, name, data_type):
        name = name.split(".")[-1]
        g = self.generator
        odd = g.random() < self.odd
        if data_type is BOOL:
            return g.random() < OFTEN.get(name, 0.4)
        if data_type is TIME:
            if odd:
                return g.choice(ODD_TIMES)
            return int(
                self.cycle * g.choice([0, 0.5, 1, 2, 3, 5, 10, 20, 40, g.uniform(0, 50), g.uniform(0, 500)])
            )
        if data_type is REAL:
            if odd:
                return g.choice(ODD_REALS)
            if name in ("PV_FAC", "LMN_FAC", "GAIN"):
                return g.choice([1.0, 2.0, g.uniform(-2, 3)])
            if name == "RATIOFAC":
                return g.choice([1.0, 0.5, 2.0, g.uniform(0.1, 10), g.uniform(-1, 20)])
            if name == "INV":
                return g.choice([g.randint(-110, 110), g.randint(-20, 20) * 5, g.uniform(-120, 120)])
            if name == "DEADB_W":
                return g.choice([0.0, 0.0, 1.0, g.uniform(0, 5)])
            if name == "LMN_HLM":
                return g.choice([100.0, 100.0, g.uniform(5, 100), g.uniform(-20, 20)])
            if name == "LMN_LLM":
                return g.choice([0.0, -100.0, -100.0, g.uniform(-100, 5), g.uniform(-20, 20)])
            if name == "MAN":
                return g.uniform(-120, 120)
            return g.choice([0.0, float(g.randint(-10, 10)), g.uniform(-10, 10), g.uniform(-50, 50)])
        if odd:
            return g.choice(ODD_INTS)
        if data_type is WORD and name == "PV_PER":
            return g.choice([g.randint(-3000, 3000), g.randint(-32768, 32767)])
        return g.choice(
            [g.randint(-20, 20), g.randint(0, 30), g.randint(-1000, 1000), g.randint(-32768, 32767)]
        )


def terminals(block, kind, prefix=""):
    """The data types of INPUTS or OUTPUTS by name, those of the blocks inside too."""
    found = {prefix + name: data_type for name, (data_type, _) in getattr(block, kind).items()}
    for name, inner in vars(block).items():
        if isinstance(inner, oracle.Block):
            found.update(terminals(inner, kind, f"{prefix}{name}."))
    return found


def is_number(block):
    """Nothing in the block, its memory included, is infinite or NaN."""
    for value in vars(block).values():
        if isinstance(value, oracle.Block) and not is_number(value):
            return False
        if isinstance(value, np.float32) and not np.isfinite(value):
            return False
    return True


def as_fmi(fmu, values):
    types = {"Real": float, "Integer": int, "Boolean": int}
    return {
        name: value / 1000 if fmu.kinds[name] == "TIME" else types[fmu.variables[name].type](value)
        for name, value in values.items()
    }


@pytest.mark.parametrize("seed", range(RUNS))
@pytest.mark.parametrize("name", host.versions(oracle.BLOCKS))
def test_a_random_run_equals_the_second_text_of_the_law(name, seed, open_fmu):
    fmu = open_fmu(name)
    block = oracle.BLOCKS[fmu.name]()
    generator = random.Random(f"{name} {seed}")
    cycle = generator.choice([1, 10, 100, 1000, 1000, 12345])
    change = generator.choice([0.01, 0.03, 0.1])
    draw = Draw(generator, cycle)

    types = {n: t for n, t in terminals(block, "INPUTS").items() if fmu.variables[n].causality != "local"}
    fixed = {fmu.cycle_name: cycle}
    others = set(fmu.of("parameter", variability="fixed")) - {fmu.cycle_name}
    fixed.update({terminal: generator.choice([1, 2, 3, 7, 20]) for terminal in sorted(others)})
    tunable = {n: t for n, t in types.items() if n not in fixed}
    values = {n: draw(n, t) for n, t in tunable.items() if generator.random() < 0.5}

    instance = fmu.instance()
    instance.start(**as_fmi(fmu, {**values, **fixed}))
    for terminal, value in {**values, **fixed}.items():
        block.set(terminal, value)
    block.restart()

    outputs = list(terminals(block, "OUTPUTS"))
    comparable = True
    compared = 0
    for call in range(CALLS):
        changed = {n: draw(n, t) for n, t in tunable.items() if generator.random() < change}
        if "COM_RST" in tunable:
            changed["COM_RST"] = generator.random() < (0.01 if comparable else 0.2)
        for terminal, value in changed.items():
            block.set(terminal, value)
        values.update(changed)
        block.call()
        instance.step(cycle / 1000, **as_fmi(fmu, changed))
        # Once a block computes with an infinity or NaN, all that is promised is that it goes on,
        # and that a restart clears it.
        comparable = is_number(block) and (comparable or values["COM_RST"])
        if comparable:
            compared += 1
            expected = as_fmi(fmu, {n: block.get(n) for n in outputs})
            if block.MEAN:
                expected[block.MEAN] = 100.0 * block.pulse()
            assert host.exact(instance.get(expected)) == host.exact(expected), f"call {call}: {values}"
    assert compared > CALLS // 4
