// The file of decisions that a page gives away: seams.json without frames, which wpcal computes anew.

/** The record of seams.json with the decisions behind the seams that are shown. */
export function seamsFile(record, seams) {
  const found = new Map(record.seams.map((seam) => [JSON.stringify(seam.candidate), seam]));
  const entry = ({ name, candidate, edit }) => {
    const { edit: _, ...own } = found.get(JSON.stringify(candidate));
    return { ...own, name, ...(edit ? { edit } : {}), frames: [] };
  };
  return { ...record, seams: seams.map(entry) };
}

/** Lets the browser save a text as a file. */
export function download(name, text) {
  const address = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  const link = document.createElement("a");
  Object.assign(link, { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000); // some browsers read it after the click
}
