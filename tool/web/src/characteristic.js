/**
 * The characteristics of a pulse former with the values in its fields: the mean of the pulses as a function of the
 * input.
 */

import { element, fill, svg } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { unitText } from "tool/signals.js";
import { store, valuesOf } from "tool/store.js";
import { rounded } from "tool/values.js";

const [WIDTH, HEIGHT, LEFT, BOTTOM, TOP] = [330, 190, 38, 30, 8];

/** @param {HTMLElement} after */
export function mount(after) {
  const within = element("div.characteristics");
  after.append(within);
  let asked = 0;
  const update = async () => {
    const loop = store.loop;
    asked += 1;
    const mine = asked;
    if (!loop) return fill(within);
    const member = { name: loop.member, fmu: loop.description.name, values: valuesOf(loop) };
    try {
      const { sweeps } = await ask({ do: "characteristic", member });
      // A flat curve explains nothing: in automatic mode, the manual value has no effect on any output.
      if (mine === asked) fill(within, sweeps.filter(isMoving).map(chart));
    } catch {
      // A value that the block rejects is reported beside its field.
      if (mine === asked) fill(within);
    }
  };
  let timer = 0;
  const soon = () => {
    clearTimeout(timer);
    timer = setTimeout(update, 60);
  };
  store.on("loop", () => {
    fill(within);
    soon();
  });
  store.on("checked", soon);
}

/** Whether an output of a sweep depends on the input. @param {import("./messages").Sweep} sweep */
function isMoving({ outputs }) {
  return outputs.some(([, values]) => Math.max(...values) > Math.min(...values));
}

/** @param {import("./messages").Sweep} sweep */
function chart(sweep) {
  const [low, high] = [sweep.inputs[0], sweep.inputs[sweep.inputs.length - 1]];
  const all = sweep.outputs.flatMap(([, values]) => values);
  const least = Math.min(0, ...all);
  const most = Math.max(0, ...all) || (least === 0 ? 1 : 0);
  const x = (/** @type {number} */ value) => LEFT + ((value - low) / (high - low || 1)) * (WIDTH - LEFT - 10);
  const y = (/** @type {number} */ value) =>
    HEIGHT - BOTTOM - ((value - least) / (most - least || 1)) * (HEIGHT - BOTTOM - TOP);
  const grid = [];
  for (const part of [0, 0.25, 0.5, 0.75, 1]) {
    const [across, up] = [low + part * (high - low), least + part * (most - least)];
    grid.push(
      svg("path.grid", { d: `M${x(across)} ${TOP}V${HEIGHT - BOTTOM}M${LEFT} ${y(up)}H${WIDTH - 10}` }),
      svg("text.axis", { x: x(across), y: HEIGHT - BOTTOM + 14, "text-anchor": "middle" }, rounded(across, "", 3)),
      svg("text.axis", { x: LEFT - 5, y: y(up) + 4, "text-anchor": "end" }, rounded(up, "", 3)),
    );
  }
  const unit = sweep.unit ? ` in ${unitText(sweep.unit)}` : "";
  const lines = sweep.outputs.map(([, values], at) =>
    svg("polyline", {
      class: `curve curve-${at + 1}`,
      points: sweep.inputs.map((input, i) => `${x(input)},${y(values[i])}`).join(" "),
    }),
  );
  const label = `${sweep.title}: ${sweep.outputs.map(([name]) => name).join(", ")} as a function of ${sweep.variable}`;
  return element(
    "figure.characteristic",
    svg(
      "svg",
      { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label },
      ...grid,
      ...lines,
      svg("text.axis", { x: (LEFT + WIDTH) / 2, y: HEIGHT - 3, "text-anchor": "middle" }, sweep.variable + unit),
    ),
    element(
      "figcaption",
      sweep.title,
      element(
        "span.row",
        sweep.outputs.map(([name], at) =>
          element("span", { class: `key curve-${at + 1}` }, `${at === 0 ? "\u2500" : "\u2504"} ${name}`),
        ),
      ),
    ),
  );
}
