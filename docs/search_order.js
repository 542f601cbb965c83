// How the search orders what it finds: headings that are the question, then pages for people, then the library.
var Scorer = {
  score: ([name, , , , score, , kind]) => score + (kind === "title" ? 100 : name.startsWith("reference/library/") ? -100 : 0),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 30,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
