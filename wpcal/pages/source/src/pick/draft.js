// The server's copy of the table: every change goes there at once, and the changes of other windows come from there.
import { FAULTS, latestOnly, post } from "./link.js";
import { isSameTable, mergeTables } from "./merge.js";
import { randomName } from "./names.js";

const POLL_MS = 1000; // how late this window shows what was typed in another
const LARGEST_LAST_BYTES = 60_000; // browsers send at most 64 kB after a page is closed

export class Draft {
  /**
   * @param {Rows} rows
   * @param {{revision: number, table: object, saves_to: string}} start  the table from which `rows` was made
   * @param {{onTheirs: function(merged), onFault: function(fault), onName: function(string)}} on  `merged` as from
   *   `mergeTables`, when another window changed the table
   */
  constructor(rows, start, on) {
    Object.assign(this, { rows, on, base: rows.toRecord(), revision: start.revision });
    this.window = randomName();
    this.number = 0;
    this.fault = null; // of the last request
    this.undecided = []; // cells where this window put its text in place of another window's, until a person chooses
    this.last = Promise.resolve();
    this.exchange = latestOnly(() => this.update(), 0);
    setInterval(() => this.exchange.isIdle && !document.hidden && this.exchange.ask(), POLL_MS);
    addEventListener("visibilitychange", () => document.hidden || this.exchange.ask());
    addEventListener("pagehide", () => this.sendLast());
  }

  /** Whether the server has the table as it is here. */
  get isKept() {
    return isSameTable(this.rows.toRecord(), this.base);
  }

  /** Whether a change would be lost with this window. */
  get isAtRisk() {
    return !this.isKept && (this.fault !== null || this.lastBody().length > LARGEST_LAST_BYTES);
  }

  get isIdle() {
    return this.isKept || this.fault !== null;
  }

  /** The table has changed in this window. */
  change() {
    this.exchange.ask();
  }

  /** Runs a task that talks to the server about the table, after the one before. */
  queue(task) {
    const run = this.last.then(task);
    this.last = run.catch(() => {});
    return run;
  }

  update() {
    return this.queue(async () => {
      if (await this.keep()) await this.look();
    });
  }

  /** Sends changes until the server has them; returns whether it does. To be called in a task of `queue`. */
  async keep() {
    while (!this.isKept) {
      const table = this.rows.toRecord();
      const { answer, fault = null } = await post("keep", { ...this.own(), table });
      this.tell(fault);
      if (fault) return false;
      if (answer.is_stale) this.take(answer);
      else {
        Object.assign(this, { base: table, revision: answer.revision });
        this.warn(answer.warning);
      }
    }
    return true;
  }

  async look() {
    const { answer, fault = null } = await post("table", { revision: this.revision });
    if (fault) this.fault = fault;
    else if (answer.table) this.take(answer);
    else this.fault = null;
  }

  /** Merges a newer table of the server into this one. */
  take(answer) {
    const merged = mergeTables(this.base, this.rows.toRecord(), answer.table);
    Object.assign(this, { base: answer.table, revision: answer.revision, fault: null });
    this.undecided = [...this.undecided, ...merged.conflicts];
    this.on.onName(answer.saves_to);
    if (!isSameTable(this.rows.toRecord(), merged.table)) this.on.onTheirs(merged);
    else if (merged.conflicts.length) this.on.onTheirs(merged);
  }

  /** The person has seen these conflicts and chosen. */
  decided(conflicts) {
    this.undecided = this.undecided.filter((one) => !conflicts.includes(one));
  }

  /** What the page shows at a click: to be saved if nothing else comes in between. */
  get shown() {
    return { shown: this.revision, window: this.window };
  }

  /** The server has saved the table, perhaps under another name. */
  saved({ revision, file }) {
    this.revision = revision;
    this.on.onName(file);
  }

  /** The rows are now the server's. */
  replaced({ revision }) {
    Object.assign(this, { base: this.rows.toRecord(), revision });
  }

  /** Says a new fault once. That the server is gone is said with the fit. */
  tell(fault) {
    const isNew = fault && fault.message !== this.fault?.message && fault.code !== FAULTS.noServer;
    this.fault = fault;
    if (isNew) this.on.onFault(fault.message);
  }

  warn(message) {
    if (message && message !== this.warning) this.on.onFault(message);
    this.warning = message;
  }

  own() {
    this.number += 1;
    const conflicts = this.undecided.map(idOf);
    return { revision: this.revision, window: this.window, number: this.number, conflicts };
  }

  lastBody() {
    return JSON.stringify({ ...this.own(), table: this.rows.toRecord() });
  }

  /** The window closes: its last change goes to the server, which answers to nobody. */
  sendLast() {
    if (this.isKept) return;
    const headers = { "Content-Type": "application/json" };
    fetch("keep", { method: "POST", headers, body: this.lastBody(), keepalive: true }).catch(() => {});
  }
}

/** A conflict in the words of the server: the cell and both texts. */
export function idOf({ key, column, mine, theirs }) {
  return JSON.stringify([key, column, mine, theirs]);
}
