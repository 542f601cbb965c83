// The list of seams with the reasons against those that are refused: to search, to sort, and to tick several.
import { el, fixed, table } from "../dom.js";
import { memberRows, solidLinks } from "./members.js";

const KINDS = { all: () => true, accepted: ({ accepted }) => accepted, refused: ({ accepted }) => !accepted };

export class SeamList {
  /**
   * @param {{onChoose: function(number), onTick: function(string[], boolean), members: object[]}} on
   *   `onChoose` gets the row of a seam, `onTick` names of seams and whether they are ticked; `members` is what the
   *   solids are taken for
   * @param {string} [id]
   */
  constructor({ onChoose, onTick, members }, id = "seams") {
    Object.assign(this, { onChoose, onTick, members, sort: { title: null, sign: 1 }, kind: "all" });
    const again = () => this.fill();
    this.kinds = Object.keys(KINDS).map((kind) =>
      el("button", { type: "button", "data-kind": kind, onclick: () => this.only(kind) }, kind),
    );
    this.words = el("input", {
      type: "search",
      name: "words",
      placeholder: "name, solid, joint, reason",
      autocomplete: "off",
      spellcheck: "false",
      oninput: again,
    });
    this.shown = el("span", { class: "shown", role: "status" });
    this.body = el("div", {});
    const search = el("div", { class: "search" }, [
      el("div", { class: "kinds", role: "group", "aria-label": "which seams" }, this.kinds),
      el("label", {}, el("span", {}, "with"), this.words),
      this.shown,
    ]);
    this.element = el("section", { id, class: "seam-list" }, search, this.body);
  }

  /**
   * @param {object[]} seams
   * @param {number|null} chosen  row
   * @param {Set<string>} ticked  names
   */
  show(seams, chosen, ticked) {
    Object.assign(this, { seams, chosen, ticked });
    this.fill();
  }

  /** Shows the seams with these words only. */
  find(words) {
    this.words.value = words;
    this.only("all");
    this.element.scrollIntoView({ block: "nearest" });
    this.words.focus();
  }

  only(kind) {
    this.kind = kind;
    this.fill();
  }

  fill() {
    for (const button of this.kinds) button.setAttribute("aria-pressed", String(button.dataset.kind === this.kind));
    const seams = foundSeams(this.seams, this.kind, this.words.value, this.members);
    const columns = this.columns(seams);
    const { title, sign } = this.sort;
    const by = columns.find((column) => column.name === title)?.by;
    const sorted = by ? seams.toSorted((a, b) => sign * compared(by(a), by(b))) : seams;
    const rowOf = (seam) => {
      const kinds = ["link", seam.accepted ? "" : "dim", this.seams.indexOf(seam) === this.chosen ? "chosen" : ""];
      return { class: kinds.filter(Boolean).join(" "), "data-name": seam.name };
    };
    this.shown.textContent = seams.length < this.seams.length ? `${seams.length} of ${this.seams.length}` : "";
    this.body.replaceChildren(table(columns, sorted, { rowOf }));
  }

  columns(seams) {
    const choose = (seam) => () => this.onChoose(this.seams.indexOf(seam));
    const name = (seam) => el("button", { type: "button", class: "name", onclick: choose(seam) }, seam.name);
    const first = { title: this.tickBox("all that are shown", seams), cell: (seam) => this.tickBox(seam.name, [seam]) };
    const others = [
      { name: "seam", by: ({ name }) => name, cell: name },
      { name: "joint", by: ({ joint }) => joint, cell: ({ joint }) => joint },
      { name: "weld", by: ({ weld }) => weld, cell: ({ weld }) => weld },
      { name: "joins", by: ({ solids }) => solids.join(" + "), cell: ({ solids }) => solidLinks(this.members, solids) },
      { name: "length mm", number: true, by: ({ length_mm }) => length_mm, cell: ({ length_mm }) => fixed(length_mm) },
      {
        name: "confidence",
        number: true,
        by: ({ confidence }) => confidence,
        cell: ({ confidence }) => `${Math.round(100 * confidence)} %`,
      },
      { name: "reasons against it", by: reasonsOf, cell: reasonsOf },
    ];
    return [
      first,
      ...others.map((column) => ({ ...column, title: this.sorter(column.name), sorted: this.way(column) })),
    ];
  }

  tickBox(what, seams) {
    const names = seams.map((seam) => seam.name);
    const checked = names.length > 0 && names.every((one) => this.ticked.has(one));
    const onchange = ({ target }) => {
      this.onTick(names, target.checked);
      if (names.length !== 1 || this.seams.length === 1) this.fill();
    };
    return el("input", { type: "checkbox", class: "tick", "aria-label": `tick ${what}`, checked, onchange });
  }

  way({ name }) {
    return this.sort.title === name ? (this.sort.sign > 0 ? "ascending" : "descending") : null;
  }

  /** The head of a column: a click sorts by it, the next one the other way round. */
  sorter(title) {
    const onclick = () => {
      this.sort = { title, sign: this.sort.title === title ? -this.sort.sign : 1 };
      this.fill();
      this.body.querySelector(`[data-sort="${title}"]`).focus();
    };
    const attributes = { type: "button", class: "sort", "data-sort": title, title: `sort by ${title}`, onclick };
    return el("button", attributes, title);
  }
}

/** The seams of a kind (all, accepted, refused) whose line has every one of the words; so have names of members. */
export function foundSeams(seams, kind, text, members = []) {
  const on = memberRows(members).filter((row) => row.seams);
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const has = (seam) => {
    const { name, joint, weld, solids } = seam;
    const those = on.filter((row) => row.seams.includes(name)).map((row) => row.name);
    const line = [name, joint, weld, ...solids, ...those, reasonsOf(seam)].join(" ").toLowerCase();
    return words.every((word) => line.includes(word));
  };
  return seams.filter((seam) => KINDS[kind](seam) && has(seam));
}

/** W9 before W10. */
function compared(a, b) {
  return typeof a === "number" ? a - b : a.localeCompare(b, "en", { numeric: true });
}

/** What speaks against a seam; by whose decision it is refused, if a person decided. */
export function reasonsOf({ accepted, against, edit, pending }) {
  const byHand = edit?.reject ? "refused by hand" : edit?.accept ? (accepted ? "accepted by hand" : "") : "";
  return [byHand, ...against, pending ? "wpcal judges it anew when it gets the file" : ""].filter(Boolean).join("; ");
}
