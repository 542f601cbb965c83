// The curves of one plan: joints of both robots, attitude of the seam and the torch, distances between bodies.
import { el, fixed } from "../dom.js";
import { timeChart } from "./time_chart.js";
import { rowAt } from "./times.js";

/** Returns {element, show(plan), cursor(t)}; `onSeek(t)` is called for a click in a chart. */
export function buildCurves(data, onSeek) {
  const element = el("div", { class: "charts" });
  let charts = [];
  return {
    element,
    show(plan) {
      const common = { burns: [plan.t[plan.first], plan.t[plan.last]], onSeek };
      charts = [
        joints(data, plan, 1, common),
        joints(data, plan, 2, common),
        attitude(plan, common),
        clearance(data, plan, common),
      ];
      element.replaceChildren(...charts.map((chart) => chart.element));
    },
    cursor: (t) => charts.forEach((chart) => chart.cursor(t)),
  };
}

function joints(data, plan, robot, common) {
  const series = data.joints[robot - 1].map((name, i) => ({
    name,
    t: plan.t,
    values: plan[`joints${robot}`].map((q) => q[i]),
  }));
  return timeChart(`Robot ${robot}: joints, deg`, series, common);
}

function attitude(plan, common) {
  const series = ["slope", "rotation", "work", "travel"].map((name) => ({ name, t: plan.t, values: plan[name] }));
  return timeChart("Seam against gravity and torch on the seam, deg", series, common);
}

/** The least margin over all pairs of bodies. The line below the chart names the pair. */
function clearance(data, plan, common) {
  const { checked } = plan;
  if (!checked)
    return timeChart("Clearance, mm", [{ name: "margin", t: plan.t, values: plan.t.map(() => null) }], common);
  const says = (t) => {
    const row = rowAt(checked.t, t);
    const pair = data.pairs[checked.pair[row]];
    const required = checked.distance[row] - checked.margin[row];
    return pair ? `${pair.join(" to ")}: ${fixed(checked.distance[row], 1)} mm, ${fixed(required, 0)} mm required` : "";
  };
  const series = [{ name: "margin", t: checked.t, values: checked.margin }];
  const limit = { value: 0, text: "safety distance" };
  return timeChart("Clearance beyond the safety distance, mm", series, { ...common, limit, says });
}
