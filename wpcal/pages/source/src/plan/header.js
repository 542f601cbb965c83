// The head of the page: which plan is shown, and whether it is free of collisions.
import { el, fixed } from "../dom.js";

const STAMPS = { free: "FREE", "not free": "NOT FREE", unchecked: "UNCHECKED" };
const CLASSES = { free: "pass", "not free": "fail", unchecked: "open" };

/** Returns {element, show(row)}. */
export function buildHeader(data) {
  const stamp = el("p", { class: "stamp", "data-test": "freedom" });
  const checked = el("p", { "data-test": "checked" });
  const speed = el("p", {});
  const tip = el("p", { "data-test": "tip" });
  const which = el("p", { class: "eyebrow", "data-test": "which" });
  const title = el(
    "div",
    { class: "title" },
    which,
    el("h1", {}, `Seam ${data.seam}`),
    el("p", {}, data.cell),
    speed,
    tip,
  );
  const odd = data.issues.map(({ message }) => el("li", {}, message));
  if (odd.length) title.append(el("ul", { class: "issues", "data-test": "issues" }, odd));
  const element = el("header", {}, title, el("div", { class: "verdict" }, stamp, checked));
  return {
    element,
    show(row) {
      const plan = data.plans[row];
      element.className = CLASSES[plan.freedom];
      which.textContent = `plan ${row + 1} of ${data.plans.length}${row === data.chosen ? ", the chosen one" : ""}`;
      stamp.textContent = STAMPS[plan.freedom];
      checked.replaceChildren(...checkedText(plan));
      speed.textContent = plan.schedule;
      tip.textContent = plan.between_points;
    },
  };
}

function checkedText({ check }) {
  if (!check) return ["no distances between the bodies were checked"];
  if (!check.between) return [`${check.states} states; no pair of bodies can meet`];
  const [distance, place] = [fixed(check.least_distance_mm, 1), fixed(check.s_mm, 1)];
  const least = `least: ${check.between.join(" to ")}, ${distance} mm at s = ${place} mm`;
  return [`${check.states} states checked with convex hulls`, el("br"), least];
}
