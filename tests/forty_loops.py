"""A synthetic plant of forty control loops, as the STEP 7 source text `parameters/plant.awl` and as the values in it.

No vendor's tool has written this text, and no plant has these loops: it is made up after the public descriptions of the
format. `python tests/forty_loops.py` writes the file anew; the same numbers come out every time.
"""

import pathlib
import random
import struct

FILE = pathlib.Path(__file__).parent / "parameters" / "plant.awl"

# The members of an instance data block up to its memory, in their order: inputs and parameters, then outputs.
BLOCKS = {
    "CONT_C": (
        "FB 41",
        "COM_RST:BOOL MAN_ON:BOOL PVPER_ON:BOOL P_SEL:BOOL I_SEL:BOOL INT_HOLD:BOOL I_ITL_ON:BOOL D_SEL:BOOL CYCLE:TIME "
        "SP_INT:REAL PV_IN:REAL PV_PER:WORD MAN:REAL GAIN:REAL TI:TIME TD:TIME TM_LAG:TIME DEADB_W:REAL LMN_HLM:REAL "
        "LMN_LLM:REAL PV_FAC:REAL PV_OFF:REAL LMN_FAC:REAL LMN_OFF:REAL I_ITLVAL:REAL DISV:REAL",
        "LMN:REAL LMN_PER:WORD QLMN_HLM:BOOL QLMN_LLM:BOOL LMN_P:REAL LMN_I:REAL LMN_D:REAL PV:REAL ER:REAL",
    ),
    "CONT_S": (
        "FB 42",
        "COM_RST:BOOL LMNR_HS:BOOL LMNR_LS:BOOL LMNS_ON:BOOL LMNUP:BOOL LMNDN:BOOL PVPER_ON:BOOL CYCLE:TIME SP_INT:REAL "
        "PV_IN:REAL PV_PER:WORD GAIN:REAL TI:TIME DEADB_W:REAL PV_FAC:REAL PV_OFF:REAL PULSE_TM:TIME BREAK_TM:TIME "
        "MTR_TM:TIME DISV:REAL",
        "QLMNUP:BOOL QLMNDN:BOOL PV:REAL ER:REAL",
    ),
    "PULSEGEN": (
        "FB 43",
        "INV:REAL PER_TM:TIME P_B_TM:TIME RATIOFAC:REAL STEP3_ON:BOOL ST2BI_ON:BOOL MAN_ON:BOOL POS_P_ON:BOOL "
        "NEG_P_ON:BOOL SYN_ON:BOOL COM_RST:BOOL CYCLE:TIME",
        "QPOS_P:BOOL QNEG_P:BOOL",
    ),
}

# What a member may be in this plant: a range of milliseconds or of numbers, or how often it is TRUE.
MILLISECONDS = {
    "CYCLE": (100, 2000),
    "TI": (2_000, 600_000),
    "TD": (1_000, 60_000),
    "TM_LAG": (500, 10_000),
    "PER_TM": (40_000, 60_000),
    "P_B_TM": (20, 500),
    "PULSE_TM": (2_000, 6_000),
    "BREAK_TM": (2_000, 6_000),
    "MTR_TM": (20_000, 120_000),
}
NUMBERS = {
    "SP_INT": (10.0, 90.0),
    "GAIN": (-8.0, 8.0),
    "LMN_HLM": (80.0, 100.0),
    "LMN_LLM": (0.0, 10.0),
    "DEADB_W": (0.0, 2.0),
    "PV_FAC": (0.5, 5.0),
    "LMN_FAC": (0.9, 1.0),
    "LMN_OFF": (-5.0, 5.0),
    "RATIOFAC": (0.1, 10.0),
}
TRUE = {
    "COM_RST": 0.0,
    "MAN_ON": 0.1,
    "LMNS_ON": 0.1,
    "INT_HOLD": 0.05,
    "I_ITL_ON": 0.05,
    "P_SEL": 1.0,
    "I_SEL": 0.95,
}


class Loop:
    """A loop: its name, block, data block's number, and the literal and value of each member that the file sets."""

    def __init__(self, name, block, number, *, is_short=False):
        self.name, self.block, self.number = name, block, number
        self.inputs, self.outputs = (
            [entry.split(":") for entry in entries.split()] for entries in BLOCKS[block][1:]
        )
        self.literals, self.values = {}, {}
        dice = random.Random(name)
        for member, kind in self.inputs:
            literal, value = SETTINGS[kind](member, dice)
            # What an engineer types is what differs from the default; what STEP 7 generates has every member.
            if not is_short or dice.random() < 0.4:
                self.literals[member], self.values[member] = literal, value

    def type(self):
        return BLOCKS[self.block][0]


def real(member, dice):
    low, high = NUMBERS.get(member, (-100.0, 100.0))
    number = dice.choice([round(dice.uniform(low, high), 2), dice.uniform(low, high)])
    mantissa, exponent = f"{number:.6e}".split("e")
    literal = f"{mantissa}e{int(exponent):+04d}"
    return literal, struct.unpack("f", struct.pack("f", float(literal)))[0]


def time(member, dice):
    low, high = MILLISECONDS[member]
    milliseconds = dice.choice([dice.randint(low, high), dice.randint(low // 1000, high // 1000) * 1000 or low])
    rest, units = milliseconds, ""
    for unit, length in (("H", 3_600_000), ("M", 60_000), ("S", 1000), ("MS", 1)):
        if rest >= length:
            units += f"{rest // length}{unit}"
            rest %= length
    return f"T#{units}", milliseconds / 1000


def word(_, dice):
    value = dice.randint(-27648, 27648)
    return f"W#16#{value & 0xFFFF:X}", value


def boolean(member, dice):
    value = dice.random() < TRUE.get(member, 0.4)
    return str(value).upper(), value


SETTINGS = {"REAL": real, "TIME": time, "WORD": word, "BOOL": boolean}
ZERO = {"REAL": "0.000000e+000", "WORD": "W#16#0", "BOOL": "FALSE"}


def loops():
    """The forty loops in the order of the file; the two of the multi-instance are the last."""
    made = []
    for count, block, letters, number in ((18, "CONT_C", "TIC", 41), (15, "CONT_S", "FIC", 141), (5, "PULSEGEN", "YC", 241)):
        for place in range(count):
            made.append(Loop(f"{letters}{101 + place}", block, number + place, is_short=place % 3 == 2))
    return made + [Loop(name, "CONT_C", 300) for name in ("TIC_MASTER", "TIC_SLAVE")]


def source():
    """The file's text."""
    lines = ["// Synthetic: forty loops of a plant that does not exist. Written by tests/forty_loops.py.", ""]
    *single, master, slave = loops()
    for place, loop in enumerate(single):
        lines.append(f'DATA_BLOCK "{loop.name}"' if has_symbol(place, loop) else f"DATA_BLOCK DB {loop.number}")
        lines.append(f'TITLE ={loop.name}: "control" of unit {place + 1} // as built; not tuned')
        lines += ["{ S7_m_c := 'true' }"] * (place % 2)
        lines += ["AUTHOR : NOBODY", "FAMILY : CONTROL", "VERSION : 0.1", "", f" {loop.type()}"]
        lines += ["BEGIN", *assignments(loop), "END_DATA_BLOCK", ""]
    lines += ["FUNCTION_BLOCK FB 200", "TITLE =A cascade", "VERSION : 0.1", "", "VAR"]
    lines += [f"   {loop.name} : {loop.type()};" for loop in (master, slave)]
    lines += ["END_VAR", "BEGIN", "END_FUNCTION_BLOCK", "", "DATA_BLOCK DB 300", "TITLE =", "VERSION : 0.1", "", " FB 200"]
    lines += ["BEGIN", *assignments(master, f"{master.name}."), *assignments(slave, f"{slave.name}."), "END_DATA_BLOCK", ""]
    return "\r\n".join(lines)


def assignments(loop, path=""):
    lines = [f"   {path}{member} := {literal};" for member, literal in loop.literals.items()]
    if len(loop.literals) < len(loop.inputs):
        return [f"{line} // set by hand" if place == 0 else line for place, line in enumerate(lines)]
    return lines + [f"   {path}{member} := {ZERO[kind]};" for member, kind in loop.outputs]


def has_symbol(place, loop):
    """Every fourth loop has a number only, as where nobody gave symbols."""
    return place % 4 != 3 or loop.number == 300


def by_name():
    """The loops by the names that they have in the file."""
    return {
        loop.name if has_symbol(place, loop) else f"DB{loop.number}": loop for place, loop in enumerate(loops())
    }


if __name__ == "__main__":
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_bytes(source().encode())
