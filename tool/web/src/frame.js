/** Draws at most once per frame, without overlaps. */

import { store } from "tool/store.js";

/**
 * Returns a function that runs some work in the next frame, and once more if it is called in the meantime.
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
