/** Limits work such as drawing to once per frame. */

import { store } from "tool/store.js";

/**
 * Returns a function that does the work in the next frame. If it is called while the work is in progress, the work is
 * repeated once.
 *
 * @param {() => unknown} work
 */
export function onceAFrame(work) {
  let [isScheduled, isBusy, isStale] = [false, false, false];
  const soon = () => {
    isStale = true;
    if (isScheduled || isBusy) return;
    isScheduled = true;
    requestAnimationFrame(async () => {
      isScheduled = isStale = false;
      isBusy = true;
      await Promise.resolve().then(work).catch(store.say);
      isBusy = false;
      if (isStale) soon();
    });
  };
  return soon;
}
