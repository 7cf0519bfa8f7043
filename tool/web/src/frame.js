/** Drawing at most once in a frame, one after the other. */

import { store } from "tool/store.js";

/**
 * A function that does some work in the next frame; once more after it, if it is called meanwhile.
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
