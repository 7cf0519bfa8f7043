"""The tapes of the blocks, one run for each case of `clauses.txt`, on the packed FMU and on the second version of the law."""

import pytest

import host
import oracle
import tapes

RUNS = tapes.all_runs()


class OnFmu:
    """Plays a run on an FMU. Calls between which nothing is set or read are made in one step."""

    def __init__(self, fmu):
        self.fmu = fmu
        self.instance = fmu.instance()
        self.calls = 0

    def restart(self, **values):
        self.instance.start(**self.as_fmi(values))
        self.cycle = self.instance.cycle

    def set(self, **values):
        self.make_calls()
        self.instance.set(**self.as_fmi(values))

    def call(self):
        self.calls += 1

    def get(self, name):
        self.make_calls()
        return self.instance[name]

    def kind(self, name):
        return self.fmu.kinds[name]

    def make_calls(self):
        if self.calls:
            self.instance.step(self.calls * self.cycle)
        self.calls = 0

    def as_fmi(self, values):
        return {
            name: float(value) if self.fmu.variables[name].type == "Real" else int(value)
            for name, value in values.items()
        }


class OnOracle:
    """Plays a run on the second version of a law."""

    def __init__(self, block):
        self.block = block

    def restart(self, **values):
        self.set(**values)
        self.block.restart()

    def set(self, **values):
        for name, value in values.items():
            self.block.set(name, round(value * 1000) if self.kind(name) == "TIME" else value)

    def call(self):
        self.block.call()

    def get(self, name):
        value = self.block.get(name)
        return value / 1000 if self.kind(name) == "TIME" else value

    def kind(self, name):
        block, terminal = self.block.owner_of(name)
        data_type, _ = {**block.INPUTS, **block.OUTPUTS}[terminal]
        return {oracle.REAL: "REAL", oracle.TIME: "TIME"}.get(data_type)


def wrong(run, player):
    """In which calls which answers are not those of the tape."""
    found = []
    for call, (settings, answers) in enumerate(run.calls(), 1):
        if call == 1:
            player.restart(**settings)
        elif settings:
            player.set(**settings)
        player.call()
        for name, expected in answers.items():
            told = player.get(name)
            if not tapes.is_right(told, expected, player.kind(name)):
                found.append(f"{name} is {told} in call {call}, not {expected}")
    return found


@pytest.mark.parametrize("version", host.versions([""]))
@pytest.mark.parametrize("run", RUNS, ids=str)
def test_the_fmu_does_what_the_tape_says(run, version, open_fmu):
    assert wrong(run, OnFmu(open_fmu(version + run.block))) == []


@pytest.mark.parametrize("run", RUNS, ids=str)
def test_the_second_text_of_the_law_does_what_the_tape_says(run):
    assert wrong(run, OnOracle(oracle.BLOCKS[run.block]())) == []
