// The trade-off plans to choose from: a chart to click in, and a table of the same plans.
import { el, fixed, short, table } from "../dom.js";
import { ramp } from "../viewer.js";
import { frontChart } from "./front_chart.js";

/**
 * The section of the page.
 *
 * @param {object} data  of the page
 * @param {function(number)} onPick  called with the row of a plan that is clicked
 * @returns {{element, show(row)}}
 */
export function buildFront(data, onPick) {
  const { marks, element: chart } = frontChart(data, onPick);
  const { lines, element: list } = planTable(data, onPick);
  const { colour } = data.axes;
  const element = el(
    "section",
    { id: "front" },
    el("h2", {}, "Plans"),
    chart,
    colour &&
      legend(
        data.titles[colour],
        data.plans.map(({ objectives }) => objectives[colour]),
      ),
    data.fronts.map(found),
    list,
  );
  return {
    element,
    show(chosen) {
      for (const nodes of [marks, lines]) {
        nodes.forEach((node, row) => node.classList.toggle("chosen", row === chosen));
      }
      list.scrollTop = lines[chosen].offsetTop - list.clientHeight / 2;
    },
  };
}

function planTable({ plans, names, titles }, onPick) {
  const rows = plans.map((plan, row) => ({ plan, row }));
  const element = table(columns(names, titles), rows, {
    rowOf: ({ row }) => ({ "data-row": row, class: "link", onclick: () => onPick(row) }),
  });
  const lines = [...element.querySelectorAll("tbody tr")];
  return { element, lines };
}

function columns(names, titles) {
  const margin = ({ check }) => (check?.between ? short(check.least_margin_mm) : "–");
  return [
    { title: "plan", cell: ({ row }) => String(row + 1) },
    ...names.map((name) => ({ title: titles[name], number: true, cell: ({ plan }) => short(plan.objectives[name]) })),
    { title: "margin, mm", number: true, cell: ({ plan }) => margin(plan) },
    { title: "tip error, mm", number: true, cell: ({ plan }) => fixed(plan.tip.largest_tip_error_mm, 2) },
    { title: "tip speed, mm/s", number: true, cell: ({ plan }) => speeds(plan.tip) },
    { title: "path", cell: ({ plan }) => plan.freedom },
    { title: "found by", cell: ({ plan }) => plan.found_by },
  ];
}

function speeds({ slowest_mm_s, fastest_mm_s }) {
  return `${fixed(slowest_mm_s, 1)} to ${fixed(fastest_mm_s, 1)}`;
}

/** How many plans one method found by itself. */
function found({ name, values, hypervolume }, i) {
  const text = `${values.length} plans by itself, hypervolume ${fixed(hypervolume, 1)}`;
  const named = el("span", { class: "name", "data-series": i }, i === 0 ? "+ " : "× ", name);
  return el("p", { class: "names" }, named, text);
}

/** The colours of the third objective, and what the shapes mean. */
function legend(title, values) {
  const bar = el("span", { class: "ramp" });
  bar.style.background = ramp();
  const [low, high] = [Math.min(...values), Math.max(...values)].map(short);
  const words = (text) => el("span", {}, text);
  const shapes = "disc: ladder, diamond: other method; hollow: not known to be free of collisions";
  return el("p", { class: "colours" }, words(title), words(low), bar, words(high), words(shapes));
}
