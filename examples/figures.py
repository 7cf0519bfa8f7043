"""The manual's figures for PULSEGEN, reproduced with the FMU: 3-3, 3-5 and the characteristics 3-6
to 3-9.

- 3-3, pulse duration modulation: INV is the percentage of calls with a pulse, ten per period.
- 3-5, synchronization: INV changes from 30 to 80 % at each of the ten calls of a period. With
  SYN_ON the pulse for the new value begins in the next call, except for a change in the first or
  the last two calls; without it, in the next period.
- 3-6, three-step control: the pulse is proportional to |INV|. P_B_TM causes the kinks: it is 10 %
  of PER_TM here, so there is no pulse below 10 % and no break above 90 %.
- 3-7, three-step control with RATIOFAC = 0.5: half the pulse and half the threshold for negative
  INV.
- 3-8, two-step control, bipolar: (INV + 100 %) / 2.
- 3-9, two-step control, monopolar: INV, or no pulse if it is negative.

The characteristics are swept: INV rises from -110 to 110 % in steps of 0.5 %, with one period of
400 calls each, so that the pulse is a whole number of calls in every mode. Here a communication
step is one period, so Q_MEAN, the mean of the pulses over it, is the length of the pulse in percent
of PER_TM, negative for a negative pulse.
"""

import numpy as np

import plcfmu
from plcfmu import plot

CYCLE = 0.01
PER_TM, P_B_TM = 4.0, 0.4
SWEEP = np.arange(-110.0, 110.5, 0.5)

CHARACTERISTICS = {
    "3-6": ("three-step, RATIOFAC 1", {}),
    "3-7": ("three-step, RATIOFAC 0.5", {"RATIOFAC": 0.5}),
    "3-8": ("two-step, bipolar", {"STEP3_ON": False, "ST2BI_ON": True}),
    "3-9": ("two-step, monopolar", {"STEP3_ON": False}),
}

# INV is the manipulated value of a controller, but an input here.
INPUT = {**plot.MANIPULATED, "linestyle": plot.SETPOINT["linestyle"]}

# Figure 3-5: ten calls per period; INV changes at the given call of the second period.
CALLS, SHORT_CYCLE = 10, 0.1
LOW, HIGH = 30.0, 80.0


def modulation(fmus):
    """Figure 3-3: one period each of 30, 60 and 90 %, with ten calls per period. A row is a call."""
    generator = fmus.start("PULSEGEN", CYCLE=SHORT_CYCLE, PER_TM=CALLS * SHORT_CYCLE)
    result = plcfmu.Result()
    for call in range(3 * CALLS):
        t = call * SHORT_CYCLE
        inv = (30.0, 60.0, 90.0)[call // CALLS]
        generator.step(t, SHORT_CYCLE, INV=inv)
        result.add(t, INV=inv, QPOS_P=generator["QPOS_P"])
    return result


def synchronization(fmus, changes_at, syn_on):
    """Figure 3-5: INV goes from 30 to 80 % at call `changes_at` of the second of five periods. A row is a call."""
    generator = fmus.start("PULSEGEN", CYCLE=SHORT_CYCLE, PER_TM=CALLS * SHORT_CYCLE, SYN_ON=syn_on, P_B_TM=0.0)
    result = plcfmu.Result()
    for call in range(5 * CALLS):
        t = call * SHORT_CYCLE
        inv = HIGH if call >= CALLS + changes_at else LOW
        generator.step(t, SHORT_CYCLE, INV=inv)
        result.add(t, INV=inv, QPOS_P=generator["QPOS_P"])
    return result


def new_period(result):
    """The call, counted from the start of the second period, in which the first pulse of 80 % begins."""
    pulse = result["QPOS_P"].astype(int)
    for call in range(CALLS, len(pulse) - 8):
        if result["INV"][call] == HIGH and pulse[call : call + 8].all() and not pulse[call + 8]:
            return call - CALLS
    raise ValueError("no pulse of eight calls")


def characteristic(fmus, settings):
    """Figures 3-6 to 3-9: the pulse length as a function of INV. A row is a period."""
    generator = fmus.start("PULSEGEN", settings, CYCLE=CYCLE, PER_TM=PER_TM, P_B_TM=P_B_TM)
    result = plcfmu.Result()
    for number, inv in enumerate(SWEEP):
        t = number * PER_TM
        generator.step(t, PER_TM, INV=inv)
        result.add(t, INV=inv, PULSE=generator["Q_MEAN"])
    return result


def draw_modulation(result, path):
    pulses = [int(sum(result["QPOS_P"][CALLS * period : CALLS * (period + 1)])) for period in range(3)]
    title = "Figure 3-3: INV of 30, 60 and 90 % give {}, {} and {} calls of ten with a pulse".format(*pulses)
    with plot.picture(path, title, ["INV in %", "QPOS_P"], [1, 0.6]) as axes:
        end = 3 * CALLS * SHORT_CYCLE
        axes[0].stairs(result["INV"], np.append(result.time, end), baseline=None, label="INV", **INPUT)
        for call in np.flatnonzero(result["QPOS_P"]):
            axes[1].broken_barh([(call * SHORT_CYCLE, SHORT_CYCLE)], (0, 1), **plot.PULSE)
        axes[0].set_ylim(0, 105)
        axes[1].set_xlim(0, end)
        axes[1].set_yticks([0, 1], ["FALSE", "TRUE"])
        axes[1].set_xticks(np.arange(0, end + 0.01, SHORT_CYCLE), minor=True)
        axes[1].grid(which="minor", axis="x", color="#eeeeee")
        for period, on in enumerate(pulses):
            plot.event(axes, period * CALLS * SHORT_CYCLE, f"{on} calls on, {CALLS - on} off", 0.12)
        plot.legend(axes[0])


def draw_synchronization(results, path):
    latest = {
        syn_on: max(new_period(results[syn_on, call]) - call for call in range(CALLS)) for syn_on in (True, False)
    }
    title = (
        f"Figure 3-5: the pulse for a new INV begins {latest[True]} calls later at most with SYN_ON, "
        f"{latest[False]} without"
    )
    with plot.picture(path, title, ["INV changes in call"], columns=2) as axes:
        for each, syn_on in zip(axes[0], (True, False)):
            plot.label(each, f"SYN_ON = {'TRUE' if syn_on else 'FALSE'}: INV changes in call")
            for changes_at in range(CALLS):
                result = results[syn_on, changes_at]
                start = new_period(result)
                calls = np.arange(-CALLS, 2 * CALLS)
                pulse = result["QPOS_P"][: 3 * CALLS]
                for call in calls[pulse == 1]:
                    color = plot.PULSE["color"] if call >= start else plot.COMPARED["color"]
                    each.barh(changes_at, 1, left=call, height=0.62, color=color, linewidth=0)
                each.plot([changes_at] * 2, [changes_at - 0.45, changes_at + 0.45], color="black", linewidth=2.0)
            each.set_xlim(-CALLS, 2 * CALLS)
            each.set_ylim(CALLS - 0.4, -0.6)
            each.set_yticks(range(CALLS))
            each.set_xticks(range(-CALLS, 2 * CALLS + 1, 5))
            each.set_xlabel("call, counted from the start of the period")
            each.grid(axis="y", visible=False)
            each.axvline(0, color="#666666", linewidth=0.8)
            each.axvline(CALLS, color="#666666", linewidth=0.8, linestyle=(0, (4, 3)))
            each.barh(-5, 1, color=plot.COMPARED["color"], label="pulses for 30 %")
            each.barh(-5, 1, color=plot.PULSE["color"], label="pulses for 80 %")
            each.plot([], [], color="black", linewidth=2.0, label="INV changes")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        axes[0, 0].figure.legend(handles, labels, loc="outside lower center", ncol=3)


def draw_characteristics(results, path):
    def limits(pulse):
        return min(pulse[pulse > 0]), max(pulse[pulse < max(pulse)])

    positive, negative = limits(results["3-6"]["PULSE"]), limits(-results["3-7"]["PULSE"])
    title = (
        "Figures 3-6 to 3-9: P_B_TM = {:.0f} % drops pulses below {:.0f} % and fills the period above {:.0f} %;\n"
        "for negative pulses with RATIOFAC 0.5 it is below {:.0f} % and above {:.0f} %"
    ).format(100 * P_B_TM / PER_TM, *positive, *negative)
    with plot.picture(path, title, ["", ""], [1, 0.7], columns=2) as axes:
        for each, (number, (name, _)) in zip(axes.flat, CHARACTERISTICS.items()):
            result = results[number]
            inv, pulse = result["INV"], result["PULSE"]
            for chosen, color, label in (
                (pulse > 0, plot.PULSE["color"], "QPOS_P"),
                (pulse < 0, plot.OPPOSITE_PULSE["color"], "QNEG_P"),
                (pulse == 0, plot.COMPARED["color"], "no pulse"),
            ):
                if chosen.any():
                    style = {"linestyle": "none", "marker": ".", "markersize": 3, "color": color}
                    each.plot(inv[chosen], pulse[chosen], label=label, **style)
            plot.label(each, f"{number}, {name}: pulse in % of PER_TM")
            each.set_xlim(-115, 115)
            each.set_ylim(-108 if "three-step" in name else -8, 108)
            each.axhline(0, color="#666666", linewidth=0.8)
            each.axvline(0, color="#666666", linewidth=0.8)
            each.set_xlabel("INV in %" if number in ("3-8", "3-9") else "")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        axes[0, 0].figure.legend(handles, labels, loc="outside lower center", ncol=3, markerscale=3)


def main():
    folder, out = plcfmu.arguments(__doc__)
    with plcfmu.Fmus(folder) as fmus:
        print("The manual's figures of PULSEGEN")
        of_3_3 = modulation(fmus)
        of_3_5 = {
            (syn_on, call): synchronization(fmus, call, syn_on) for syn_on in (True, False) for call in range(CALLS)
        }
        of_the_others = {number: characteristic(fmus, settings) for number, (_, settings) in CHARACTERISTICS.items()}
        print(f"  3-3: 30 % of ten calls is {int(sum(of_3_3['QPOS_P'][:CALLS]))} calls with a pulse")
        for syn_on in (True, False):
            starts = [new_period(of_3_5[syn_on, call]) for call in range(CALLS)]
            print(f"  3-5: INV changes in calls 0 ... 9, SYN_ON {syn_on}: the new pulse begins in calls {starts}")

        of_3_3.to_csv(out / "figure_3_3.csv", digits=9)
        together = plcfmu.Result()
        for row in range(5 * CALLS):
            columns = {
                f"SYN_{'ON' if syn_on else 'OFF'}_{call}": result["QPOS_P"][row]
                for (syn_on, call), result in of_3_5.items()
            }
            together.add(of_3_5[True, 0].time[row], **columns)
        together.to_csv(out / "figure_3_5.csv", digits=9)
        for number, result in of_the_others.items():
            result.to_csv(out / f"figure_{number.replace('-', '_')}.csv", digits=9)
        draw_modulation(of_3_3, out / "figure_3_3")
        draw_synchronization(of_3_5, out / "figure_3_5")
        draw_characteristics(of_the_others, out / "figures_3_6_to_3_9")
    print(f"  CSV, PNG and SVG: {out}")


if __name__ == "__main__":
    main()
