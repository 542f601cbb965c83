// Below the short tables of the picker: every candidate to search and to tick, and what the solids are taken for.
import { el } from "../dom.js";
import { SeamList } from "../seams/list.js";
import { memberTable } from "../seams/members.js";

export class AllSeams {
  /**
   * @param {SeamEditor} editor  decides about the seams that are ticked
   * @param {object[]} members  what the solids are taken for
   * @param {function(number)} onChoose  gets the row of a seam
   * @param {{onSay: function(string, string), options: string}} said  about solids (`memberTable`)
   */
  constructor(editor, members, onChoose, said) {
    Object.assign(this, { editor, said });
    const onTick = (names, isOn) => editor.tick(names, isOn);
    this.list = new SeamList({ onChoose, onTick, members }, "all-seams");
    this.solids = this.table(members);
    const words = this.solids ? "search and tick seams; what the solids are taken for" : "search and tick seams";
    this.element = el("details", { class: "all", ontoggle: () => this.show() }, el("summary", {}, words));
  }

  table(members) {
    return memberTable(members, (solid) => this.list.find(solid), this.said);
  }

  /** Something was said about a solid: shows what the solids are taken for now. */
  takeSolids({ members, options }) {
    this.said = { ...this.said, options };
    const solids = this.table(members);
    this.list.members = members;
    if (this.solids?.isConnected) this.solids.replaceWith(solids);
    this.solids = solids;
  }

  /** A long list costs nothing until somebody opens it. */
  show() {
    if (!this.element.open) return;
    if (!this.list.element.isConnected) this.element.append(...[this.list.element, this.solids].filter(Boolean));
    const { state, selected, ticked } = this.editor;
    this.list.show(state.seams, selected, ticked);
  }
}
