// What a person states about welds, on top of what wpcal found: with undo, and as the file that wpcal takes.
import { isCause, misfit, SIZES } from "./values.js";

export class Statements {
  /** @param {{welds: object[], head: object, without_seam: object[], found_again: string[]}} data  of the page */
  constructor(data) {
    Object.assign(this, { data, done: [], undone: [] });
    this.rows = new Map(data.welds.map((weld, row) => [weld.name, row]));
    this.first = data.welds.map(({ values, origin }) => ofUser(values, origin));
    this.now = this.first;
  }

  get isChanged() {
    return JSON.stringify(this.now) !== JSON.stringify(this.first);
  }

  /**
   * The value of a weld as it is now.
   *
   * @returns {{value: any, from: string, of: string, isStale: boolean}}  `value` is undefined if nothing states one;
   *   `isStale`: wpcal computes it anew
   */
  value(row, name) {
    const stated = this.now[row];
    if (name in stated) return { value: stated[name], from: "user", of: "", isStale: false };
    if (stated[SIZES[name]] != null) return { value: undefined, from: "", of: "", isStale: false };
    const { values, origin, rules } = this.data.welds[row];
    const [source, of] = origin[name]?.from === "user" ? [rules.values, rules.origin[name]] : [values, origin[name]];
    const found = of ?? rules.origin[name];
    const value = of ? source[name] : rules.values[name];
    return { value, from: found?.from ?? "", of: found?.of ?? "", isStale: this.isStale(row, found) };
  }

  isStale(row, origin) {
    if (origin && origin.from !== "rule") return false;
    const [before, now] = [this.first[row], this.now[row]];
    const names = new Set([...Object.keys(before), ...Object.keys(now)]);
    return [...names].some((name) => isCause(name) && JSON.stringify(before[name]) !== JSON.stringify(now[name]));
  }

  /** States a value in some welds; undefined gives it back to the rules. Returns why not, or an empty text. */
  state(rows, name, value) {
    const { welds } = this.data;
    const wrong = rows.map((row) => misfit(name, value, welds[row])).find(Boolean);
    if (wrong) return wrong;
    const next = this.now.map((stated, row) => (rows.includes(row) ? withValue(stated, name, value) : stated));
    if (JSON.stringify(next) === JSON.stringify(this.now)) return "";
    this.done.push(this.now);
    this.undone = [];
    this.now = next;
    return "";
  }

  undo() {
    this.go(this.done, this.undone);
  }

  redo() {
    this.go(this.undone, this.done);
  }

  go(from, to) {
    if (!from.length) return;
    to.push(this.now);
    this.now = from.pop();
  }

  /** The record that wpcal takes with --values: what people and files stated, and what went back to the rules. */
  file() {
    const { head, without_seam, welds } = this.data;
    return { ...head, welds: welds.map((weld, row) => this.entry(weld, row)), without_seam };
  }

  entry({ name, place, values, origin }, row) {
    const stated = this.now[row];
    const files = Object.entries(origin).filter(
      ([key, { from, of }]) => from === "file" && !this.data.found_again.includes(of) && !(key in stated),
    );
    const kept = files.filter(([key]) => stated[SIZES[key]] == null);
    const givenBack = Object.keys(this.first[row]).filter((key) => !(key in stated));
    return {
      name,
      place,
      values: { ...Object.fromEntries(kept.map(([key]) => [key, values[key]])), ...stated },
      origin: {
        ...Object.fromEntries(kept.map(([key, { from, of }]) => [key, { from, of, given: values[key] }])),
        ...Object.fromEntries(Object.entries(stated).map(([key, given]) => [key, { from: "user", given }])),
      },
      ...(givenBack.length ? { given_back: givenBack } : {}),
    };
  }
}

function ofUser(values, origin) {
  return Object.fromEntries(Object.entries(values).filter(([name]) => origin[name].from === "user"));
}

function withValue(stated, name, value) {
  const { [name]: _, ...others } = stated;
  if (value === undefined) return others;
  const other = SIZES[name];
  if (other && value !== null) delete others[other];
  return { ...others, [name]: value };
}
