/**
 * Starts the page. The module of each panel exports a function `mount`, which is passed the element for the panel's
 * content.
 */

import { mount as bar } from "tool/bar.js";
import { mount as compare } from "tool/compare.js";
import { mount as curves } from "tool/curves.js";
import { mount as diagram } from "tool/diagram.js";
import { byId } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { mount as figures } from "tool/figures.js";
import { openGiven } from "tool/files.js";
import { mount as ghost } from "tool/ghost.js";
import { mount as help } from "tool/help.js";
import { mount as keyboard } from "tool/keyboard.js";
import { openLink } from "tool/link.js";
import { mount as loops } from "tool/loops.js";
import { mount as monitor } from "tool/monitor.js";
import { mount as panels } from "tool/panels.js";
import { mount as parameters } from "tool/parameters.js";
import { mount as plant } from "tool/plant.js";
import { watchFiles } from "tool/reload.js";
import { mount as replay } from "tool/replay.js";
import { mount as run } from "tool/run.js";
import { mount as runs } from "tool/runs.js";
import { keep, resume } from "tool/session.js";
import { store } from "tool/store.js";
import { mount as takeaway } from "tool/takeaway.js";
import { mount as timing } from "tool/timing.js";
import { mount as tune } from "tool/tune.js";
import { mount as watch } from "tool/watch.js";

/**
 * The panels, by the id of their section. The first one belongs to the first page.
 *
 * @type {[string, (content: HTMLElement) => void][]}
 */
const PANELS = [
  ["loops", loops],
  ["parameters", parameters],
  ["compare", compare],
  ["help", help],
  ["program", monitor],
  ["watch", watch],
  ["diagram", diagram],
  ["curves", curves],
  ["curves", timing],
  ["run", run],
  ["runs", runs],
  ["figures", figures],
  ["plant", plant],
  ["tune", tune],
  ["replay", replay],
  ["takeaway", takeaway],
];

for (const [id, mount] of PANELS) {
  const content = byId(id).querySelector(".content");
  if (content instanceof HTMLElement) mount(content);
  // Let the browser paint the first page before mounting the panels that it does not show. A hidden page has no frames,
  // hence the timer.
  if (id === PANELS[0][0])
    await new Promise((done) => {
      requestAnimationFrame(() => setTimeout(done));
      setTimeout(done, 100);
    });
}
bar();
panels();
keyboard();
ghost();

try {
  store.catalogue = await ask({ do: "catalogue" });
  store.emit("catalogue");
  await resume();
  await openGiven();
  await openLink();
  store.emit("ready");
  await watchFiles();
} catch (error) {
  store.say(error);
}
keep();
addEventListener("hashchange", () => openLink().catch(store.say));
