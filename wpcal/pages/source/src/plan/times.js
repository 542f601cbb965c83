// Where a time lies among the states of a plan.

/** Row of the last time that is not after `t`; 0 when `t` is before all of them. */
export function rowAt(times, t) {
  let [low, high] = [0, times.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return low;
}

/** The state before a time, and which part (0…1) of the way to the next state is done. */
export function stateAt(times, t) {
  const row = Math.max(Math.min(rowAt(times, t), times.length - 2), 0);
  const step = times[Math.min(row + 1, times.length - 1)] - times[row];
  return { row, part: Math.min(Math.max((t - times[row]) / (step || 1), 0), 1) };
}

/** A value between two states, linearly; where one of them is null, the value of the state before. */
export function valueAt({ t: times, values }, t) {
  const at = rowAt(times, t);
  const { row, part } = stateAt(times, t);
  const [before, after] = [values[row], values[Math.min(row + 1, values.length - 1)]];
  return before === null || after === null ? values[at] : before + (after - before) * part;
}
