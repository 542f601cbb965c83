// Scales: from values to places on a chart, and the round values at which an axis has its ticks.

const TICKS = 5; // per axis, about
const ROUND_OFF = 1e-9; // relative to one step: a tick at the very end of an axis is kept

/**
 * A linear scale.
 *
 * @param {[number, number]} values  at the two ends of the axis
 * @param {[number, number]} places  the same ends on the chart, in units of its viewBox
 * @returns {{at: function(number): number, back: function(number): number, ticks: number[]}}  `at`: the place of a
 *   value; `back`: the value at a place
 */
export function linear([low, high], [start, end]) {
  const slope = (end - start) / (high - low || 1);
  return {
    at: (value) => start + slope * (value - low),
    back: (place) => low + (place - start) / slope,
    ticks: roundSteps(low, high),
  };
}

/** A logarithmic scale; the values are positive, and the first may be the larger one. */
export function logarithmic([first, last], places) {
  const { at, back } = linear([Math.log10(first), Math.log10(last)], places);
  return {
    at: (value) => at(Math.log10(value)),
    back: (place) => 10 ** back(place),
    ticks: decades(Math.min(first, last), Math.max(first, last)),
  };
}

/** Multiples of 1, 2 or 5 times a power of ten, from low to high. */
export function roundSteps(low, high) {
  const least = (high - low || 1) / TICKS;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= least * (1 - ROUND_OFF));
  const first = Math.ceil(low / step - ROUND_OFF);
  const last = Math.floor(high / step + ROUND_OFF);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

/** Powers of ten from low to high; every second or third where there are many. */
export function decades(low, high) {
  const first = Math.ceil(Math.log10(low) - ROUND_OFF);
  const last = Math.floor(Math.log10(high) + ROUND_OFF);
  const step = Math.max(Math.ceil((last - first) / TICKS), 1);
  return Array.from({ length: Math.floor((last - first) / step) + 1 }, (_, i) => 10 ** (first + i * step));
}
