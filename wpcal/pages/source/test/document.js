// A document for the tests: elements are made and read, nothing is drawn.
import { parseHTML } from "linkedom";

const { document, Event } = parseHTML("<!DOCTYPE html><html><body></body></html>");
Object.assign(globalThis, { document, Event });

/** The texts of some elements inside an element. */
export function texts(element, selector) {
  return [...element.querySelectorAll(selector)].map(({ textContent }) => textContent);
}

/** One attribute of some elements inside an element. */
export function values(element, selector, name) {
  return [...element.querySelectorAll(selector)].map((found) => found.getAttribute(name));
}
