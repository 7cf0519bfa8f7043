/**
 * The first 150 s of the live loop on the first page, as computed by the engine: every third call, beginning with call
 * 2. They are shown until the engine is ready. A test compares them with the engine.
 */

export const EVERY = 3;
export const FIRST = 2;
export const SETPOINT = 60;
// biome-ignore format: numbers of a curve
export const PROCESS_VALUE = [
  20, 20, 20, 20.3, 20.8, 21.5, 22.4, 23.5, 24.7, 26, 27.4, 28.8, 30.3, 31.8, 33.4, 34.9, 36.4, 37.9, 39.4, 40.8, 42.2, 43.6, 44.8, 46.1,
  47.3, 48.4, 49.5, 50.4, 51.4, 52.3, 53.1, 53.8, 54.6, 55.2, 55.8, 56.4, 56.9, 57.3, 57.7, 58.1, 58.5, 58.8, 59, 59.3, 59.5, 59.6, 59.8,
  59.9, 60, 60.1,
];
// biome-ignore format: numbers of a curve
export const MANIPULATED_VALUE = [
  28.3, 29, 29.6, 30.1, 30.4, 30.5, 30.5, 30.3, 30.1, 29.7, 29.3, 28.8, 28.2, 27.6, 27, 26.3, 25.6, 25, 24.3, 23.6, 22.9, 22.3, 21.6, 21,
  20.4, 19.8, 19.2, 18.7, 18.2, 17.7, 17.2, 16.8, 16.4, 16, 15.7, 15.4, 15.1, 14.8, 14.5, 14.3, 14.1, 13.9, 13.7, 13.6, 13.5, 13.3, 13.2,
  13.1, 13.1, 13,
];
