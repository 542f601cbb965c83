// Below the short tables of the picker: every candidate to search and to tick, and what the solids are taken for.
import { el } from "../dom.js";
import { SeamList } from "../seams/list.js";
import { memberTable } from "../seams/members.js";

export class AllSeams {
  /**
   * @param {SeamEditor} editor  decides about the seams that are ticked
   * @param {object[]} members  what the solids are taken for
   * @param {function(number)} onChoose  gets the row of a seam
   */
  constructor(editor, members, onChoose) {
    this.editor = editor;
    const onTick = (names, isOn) => editor.tick(names, isOn);
    this.list = new SeamList({ onChoose, onTick, members }, "all-seams");
    this.solids = memberTable(members, (solid) => this.list.find(solid));
    const words = this.solids ? "search and tick seams; what the solids are taken for" : "search and tick seams";
    this.element = el("details", { class: "all", ontoggle: () => this.show() }, el("summary", {}, words));
  }

  /** A long list costs nothing until somebody opens it. */
  show() {
    if (!this.element.open) return;
    if (!this.list.element.isConnected) this.element.append(...[this.list.element, this.solids].filter(Boolean));
    const { state, selected, ticked } = this.editor;
    this.list.show(state.seams, selected, ticked);
  }
}
