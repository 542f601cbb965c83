// Two windows change one table: what each changed since the table that both know is put together.
// A table is a record of `Rows.toRecord`: {columns, rows, keys}. A row keeps its key when its cells change.

/** Whether two records hold the same table. */
export function isSameTable(a, b) {
  return JSON.stringify([a.columns, a.rows, a.keys]) === JSON.stringify([b.columns, b.rows, b.keys]);
}

/**
 * Merges two tables that were made from the same one.
 *
 * A cell that only one of them changed takes the change. Where both changed a cell to different texts, `mine` is taken
 * and the cell is a conflict. A row that one removed and the other changed stays.
 *
 * @param {object} base  the table from which both were made
 * @param {object} mine
 * @param {object} theirs
 * @returns {{table: object, changed: string[],
 *   conflicts: {key: string, row: string, column: string, mine: string, theirs: string}[]}}
 *   `changed`: names of the rows in which `table` differs from `mine`
 */
export function mergeTables(base, mine, theirs) {
  const columns = [...theirs.columns, ...mine.columns.filter((name) => !theirs.columns.includes(name))];
  const [before, own, other] = [base, mine, theirs].map((table) => cellsByKey(table, columns));
  const twins = twinsOf(before, own, other);
  for (const [key, twin] of twins) rekey(own, twin, key);
  const [rows, conflicts] = [new Map(), []];
  for (const key of new Set([...other.keys(), ...own.keys()])) {
    const merged = mergeRow(before.get(key), own.get(key), other.get(key));
    if (!merged) continue;
    rows.set(key, merged.row);
    conflicts.push(...merged.conflicts.map((conflict) => ({ key, ...conflict })));
  }
  const changed = changedNames(own, rows);
  return { table: toRecord(columns, rows), changed, conflicts };
}

/** The table with the other window's text in every cell of `conflicts`. */
export function withTheirs({ columns, rows, keys }, conflicts) {
  const cells = rows.map((row) => [...row]);
  for (const { key, column, theirs } of conflicts) {
    const row = cells[keys.indexOf(key)];
    if (row) row[columns.indexOf(column)] = theirs;
  }
  return { columns, rows: cells, keys };
}

/** Names of the rows that differ, are new or are gone. */
function changedNames(own, rows) {
  const differing = [...rows].filter(([key, row]) => !own.has(key) || !isSameRow(own.get(key), row));
  const gone = [...own].filter(([key]) => !rows.has(key));
  return [...differing, ...gone].map(([, row]) => row.name);
}

function rekey(rows, from, to) {
  rows.set(to, rows.get(from));
  rows.delete(from);
}

/** New rows with the same name and feature in both tables are one row: their key -> my key. */
function twinsOf(before, own, other) {
  const fresh = (rows) => [...rows].filter(([key, row]) => !before.has(key) && row.name);
  const twins = new Map();
  for (const [key, row] of fresh(other)) {
    if (own.has(key)) continue;
    const twin = fresh(own).find(([, mine]) => mine.name === row.name && mine.feature === row.feature);
    if (twin && !other.has(twin[0])) twins.set(key, twin[0]);
  }
  return twins;
}

/** One row of the merged table, or null if it was removed. */
function mergeRow(baseRow, mine, theirs) {
  if (mine && theirs) return mergeCells(baseRow, mine, theirs);
  const row = mine ?? theirs;
  const isRemoved = baseRow && isSameRow(baseRow, row);
  return isRemoved ? null : { row, conflicts: [] };
}

function mergeCells(baseRow, mine, theirs) {
  const [row, conflicts] = [{ ...mine }, []];
  for (const [column, text] of Object.entries(theirs)) {
    const known = baseRow?.[column] ?? "";
    if (mine[column] === text || text === known) continue;
    if (mine[column] === known) row[column] = text;
    else conflicts.push({ row: mine.name, column, mine: mine[column], theirs: text });
  }
  return { row, conflicts };
}

function isSameRow(a, b) {
  return Object.keys(b).every((name) => a[name] === b[name]);
}

/** The cells of every row by its key; a column that the table does not have is empty. */
function cellsByKey({ columns, rows, keys }, all) {
  const cells = (row) => Object.fromEntries(all.map((name) => [name, row[columns.indexOf(name)] ?? ""]));
  return new Map(rows.map((row, index) => [keys[index], cells(row)]));
}

function toRecord(columns, rows) {
  const cells = [...rows.values()].map((row) => columns.map((name) => row[name]));
  return { columns, rows: cells, keys: [...rows.keys()] };
}
