// The list of seams with the reasons against those that are refused.
import { el, fixed, table } from "../dom.js";

/**
 * @param {object[]} seams
 * @param {function(number)} onChoose  gets the row of a seam
 * @param {number|null} chosen  row
 */
export function seamList(seams, onChoose, chosen = null) {
  const name = (seam) =>
    el("button", { type: "button", class: "name", onclick: () => onChoose(seams.indexOf(seam)) }, seam.name);
  const columns = [
    { title: "seam", cell: name },
    { title: "joint", cell: ({ joint }) => joint },
    { title: "weld", cell: ({ weld }) => weld },
    { title: "joins", cell: ({ solids }) => solids.join(" + ") },
    { title: "length mm", number: true, cell: ({ length_mm }) => fixed(length_mm) },
    { title: "confidence", number: true, cell: ({ confidence }) => `${Math.round(100 * confidence)} %` },
    { title: "reasons against it", cell: reasonsOf },
  ];
  const rowOf = (seam) => {
    const kinds = ["link", seam.accepted ? "" : "dim", seams.indexOf(seam) === chosen ? "chosen" : ""];
    return { class: kinds.filter(Boolean).join(" "), "data-name": seam.name };
  };
  return table(columns, seams, { rowOf });
}

/** What speaks against a seam; by whose decision it is refused, if a person decided. */
export function reasonsOf({ accepted, against, edit, pending }) {
  const byHand = edit?.reject ? "refused by hand" : edit?.accept ? (accepted ? "accepted by hand" : "") : "";
  return [byHand, ...against, pending ? "wpcal judges it anew when it gets the file" : ""].filter(Boolean).join("; ");
}
