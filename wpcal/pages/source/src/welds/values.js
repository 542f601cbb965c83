// What can be typed for a value: its words, and whether it is one. The limits come from the schema of welds.json.

/** Names of the two sizes of a fillet: one of them decides. */
export const SIZES = { throat_mm: "leg_mm", leg_mm: "throat_mm" };
/** Values from which wpcal computes others. */
const CAUSES = new Set([
  ...["thickness_mm", "position", "weld", "throat_mm", "leg_mm", "depth_mm", "root_gap_mm", "root_face_mm"],
  ...["groove_angle_deg", "process", "wire_mm", "passes", "wire_feed_m_min", "speed_mm_s"],
]);

/** Whether values of the rules may be others once this one has changed. */
export function isCause(name) {
  return CAUSES.has(name);
}

/** A value as a cell shows it. */
export function shown(field, value) {
  if (value === undefined) return "";
  if (value === null) return "none";
  if (!field.is_record) return String(value);
  const { shape, width_mm, length_mm, pitch_mm, offset_mm, time_s, current_a, voltage_v } = value;
  if (shape !== undefined) return `${shape} ${width_mm} × ${length_mm}`;
  if (pitch_mm !== undefined) return `${length_mm} / ${pitch_mm}${offset_mm === undefined ? "" : ` from ${offset_mm}`}`;
  return [`${time_s} s`, current_a && `${current_a} A`, voltage_v && `${voltage_v} V`].filter(Boolean).join(", ");
}

/** "0.4 to 6 mm", "above 0, to 100 mm", "3 digits or letters": what is expected. */
export function limitsOf(part) {
  if (part.kind === "choice") return part.choices.join(", ");
  if (part.kind === "text") return { "^[0-9]{2,3}$": "two or three digits" }[part.pattern] ?? "letters, digits and _";
  const from = part.is_low_open ? `above ${part.low}` : `${part.low}`;
  const range = `${from} to ${part.high}${part.unit && ` ${part.unit}`}`;
  return part.kind === "whole" ? `a whole number, ${range}` : range;
}

/**
 * The value that the texts of a form mean.
 *
 * @param {object} field  of the page's data
 * @param {Record<string, string>} texts  by the name of a part
 * @returns {{value: any} | {fault: string}}
 */
export function valueFrom(field, texts) {
  const parts = field.parts.map((part) => ({ part, ...partFrom(part, (texts[part.name] ?? "").trim()) }));
  const wrong = parts.find(({ fault }) => fault);
  if (wrong) return { fault: wrong.fault };
  if (!field.is_record) return { value: parts[0].value };
  const stated = parts.filter(({ value }) => value !== undefined);
  return { value: Object.fromEntries(stated.map(({ part, value }) => [part.name, value])) };
}

function partFrom(part, text) {
  const expected = `${part.label}: expected ${limitsOf(part)}`;
  if (text === "") return part.is_needed ? { fault: expected } : { value: undefined };
  if (part.kind === "choice")
    return part.choices.includes(text) ? { value: text } : { fault: `${expected}, got ${text}` };
  if (part.kind === "text")
    return new RegExp(part.pattern).test(text) ? { value: text } : { fault: `${expected}, got ${text}` };
  const value = Number(text.replace(",", "."));
  const isIn = value <= part.high && (part.is_low_open ? value > part.low : value >= part.low);
  const isKind = part.kind === "number" || Number.isInteger(value);
  return isIn && isKind ? { value } : { fault: `${expected}, got ${text}` };
}

/** Why a value does not fit on a seam; empty if it does. */
export function misfit(name, value, { name: seam, length_mm: whole }) {
  if (!value || !["stitch", "tacks"].includes(name)) return "";
  const { length_mm, pitch_mm, offset_mm } = value;
  if (pitch_mm < length_mm) return `the pitch of ${pitch_mm} mm is shorter than the stretch of ${length_mm} mm`;
  const room = whole - (offset_mm ?? 0);
  const needs = name === "tacks" || offset_mm !== undefined;
  if (needs && room < length_mm) return `${seam} is ${whole.toFixed(1)} mm long: no room for ${length_mm} mm`;
  if (name === "tacks" && length_mm >= whole) return `${seam} is ${whole.toFixed(1)} mm long: tack welds are shorter`;
  return "";
}
