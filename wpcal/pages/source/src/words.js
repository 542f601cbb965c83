// Sentences that several pages need.
/** "1 row", "2 rows"; with the ending "es" "2 touches". */
export function plural(count, noun, ending = "s") {
  return `${count} ${noun}${count === 1 ? "" : ending}`;
}

/**
 * The verdict of a fit as a sentence. wpcal writes it; the pages only show it.
 *
 * @param {{judgement?: {sentence: string}}} calibration  or an answer of the picker's server
 */
export function verdictText({ judgement }) {
  if (!judgement) return "Written by an older version: fit again for a verdict on the seams.";
  return `${judgement.sentence.charAt(0).toUpperCase()}${judgement.sentence.slice(1)}.`;
}
