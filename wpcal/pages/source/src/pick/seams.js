// The seams of the picker: decisions go to the server, which carries them out and keeps them in a file.
import { decisionsAfter, decisionsOf, Refusal } from "../seams/decisions.js";
import { post } from "./link.js";

const POLL_MS = 1000; // how late this window shows what was decided in another

export class PickerSeams {
  /**
   * @param {number} revision  of the seams in the page
   * @param {function({seams, frames})} onTheirs  another window decided something
   * @param {function({members, judging})} onSolids  what the solids and their members are
   */
  constructor(revision, onTheirs, onSolids) {
    Object.assign(this, { revision, onTheirs, onSolids, isAsking: false });
    setInterval(() => document.hidden || this.look(), POLL_MS);
  }

  change(state, operation) {
    return this.decide(decisionsAfter(state.seams, operation));
  }

  restore(state) {
    return this.decide(decisionsOf(state.seams));
  }

  async decide(decisions) {
    this.isAsking = true;
    const { answer, fault } = await post("decide", { decisions, revision: this.revision });
    this.isAsking = false;
    if (fault) throw new Refusal(fault.message);
    this.revision = answer.revision;
    if (answer.members) this.onSolids(answer);
    if (!answer.is_stale) return { state: stateOf(answer), warning: answer.warning };
    this.onTheirs(stateOf(answer));
    throw new Refusal("Another window changed the seams at the same moment. Here they are; decide again.");
  }

  /**
   * Says what a solid or member is; the seams are found anew, which may take as long as at the start.
   *
   * @returns {Promise<string>} why not, or why it is not kept, or nothing
   */
  async say(solid, said) {
    this.isAsking = true;
    const { answer, fault } = await post("solid", { solid, said, revision: this.revision });
    this.isAsking = false;
    if (fault) return fault.message;
    this.takeTheirs(answer);
    return answer.is_stale ? "Another window changed the seams at the same moment. Say it again." : answer.warning;
  }

  takeTheirs(answer) {
    this.revision = answer.revision;
    if (answer.members) this.onSolids(answer);
    this.onTheirs(stateOf(answer));
  }

  /** Shows the seams of the server, if they are others. */
  async look() {
    if (this.isAsking) return;
    this.isAsking = true;
    const { answer } = await post("seams", { revision: this.revision });
    this.isAsking = false;
    if (answer?.seams) this.takeTheirs(answer);
  }
}

function stateOf({ seams, frames }) {
  return { seams, frames };
}
