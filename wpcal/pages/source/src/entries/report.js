// The report of a calibration: report.html.
import { centreOf } from "../bodies.js";
import { el } from "../dom.js";
import { buildScene, lookAtPoint, lookAtSeam } from "../report/scene.js";
import {
  bodiesSection,
  budgetSection,
  criteriaSection,
  fitSection,
  notesSection,
  pointsSection,
  poseSection,
  seamsSection,
  sourcesSection,
  stepsSection,
} from "../report/sections.js";
import { verdict } from "../report/verdict.js";
import { buildOrSayWhy } from "../stage.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";

async function main() {
  const { calibration, seams, pendant, mesh, steps, help } = readData();
  const [frames, part] = await Promise.all([readJsonBlob("frames"), readBlob("part")]);
  const root = document.getElementById("page");
  const view = el("section", { id: "view", "aria-label": "3-D view" });
  const focusPlace = (p) => {
    if (viewer) lookAtPoint(viewer, p);
    view.scrollIntoView({ behavior: "smooth" });
  };
  const said = [
    verdict(calibration, seams, frames),
    bodiesSection(
      calibration,
      (body) => focusPlace(centreOf(body, calibration.T_base_part)),
      (name) => focus(seams.findIndex((seam) => seam.name === name)),
    ),
    stepsSection(steps, help),
    notesSection(calibration),
  ];
  root.append(...said.filter(Boolean), view);
  const viewer = buildOrSayWhy(view, () => buildScene(view, { calibration, seams, frames, part }));
  const focus = (row) => {
    const box = view.querySelector(`input[data-layer="${seams[row].accepted ? "seams" : "candidates"}"]`);
    if (box && !box.checked) box.click();
    if (viewer) lookAtSeam(viewer, frames[row]);
    view.scrollIntoView({ behavior: "smooth" });
  };
  root.append(
    ...[
      poseSection(calibration, pendant),
      pointsSection(calibration, ({ p_base_mm }) => focusPlace(p_base_mm)),
      seamsSection(seams, frames, calibration.tolerance_mm, focus),
      budgetSection(calibration),
      criteriaSection(calibration),
      fitSection(calibration),
      sourcesSection(calibration, mesh),
    ].filter(Boolean),
  );
  window.wpcal = { viewer, project: (p) => viewer.project(p), ready: true };
  addEventListener("beforeprint", () => viewer && freeze(viewer));
}

/** Puts a picture beside the canvas, because a printer gets an empty canvas. */
function freeze(viewer) {
  const picture = el("img", { class: "print-only", alt: "the view", src: viewer.picture() });
  viewer.canvas.parentNode.querySelector("img")?.remove();
  viewer.canvas.after(picture);
}

main();
