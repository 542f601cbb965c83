// Below the short tables of the picker: every candidate to search and to tick, and the members.
import { el } from "../dom.js";
import { SeamList } from "../seams/list.js";
import { memberTable } from "../seams/members.js";

export class AllSeams {
  /**
   * @param {SeamEditor} editor  decides about the seams that are ticked
   * @param {object[]} members  what the solids and their members are
   * @param {function(number)} onChoose  gets the row of a seam
   * @param {{onSay: function(string, string), onLook: function(string), judging: object}} said  about
   *   members (`memberTable`); `onLook` gets the name of one that a person wants to see
   */
  constructor(editor, members, onChoose, said) {
    Object.assign(this, { editor, said });
    const onTick = (names, isOn) => editor.tick(names, isOn);
    this.list = new SeamList({ onChoose, onTick, members }, "all-seams");
    this.solids = this.table(members);
    const words = this.solids ? "search and tick seams; members and weights" : "search and tick seams";
    this.element = el("details", { class: "all", ontoggle: () => this.show() }, el("summary", {}, words));
  }

  table(members) {
    return memberTable(members, (name) => this.find(name), this.said);
  }

  find(name) {
    this.list.find(name);
    this.said.onLook(name);
  }

  /** Something was said about a member, or seams are others: shows what the members are now. */
  takeSolids({ members, judging }) {
    this.said = { ...this.said, judging };
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
