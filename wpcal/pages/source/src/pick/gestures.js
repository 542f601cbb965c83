// What a person does anywhere on the page: drop files, paste, press F2, Ctrl-S or Ctrl-Z, close the window.

/**
 * @param {HTMLElement} root  marked while files are dragged over the page
 * @param {{onFiles: function(File[]), onText: function(string), onSave: function, canUndo: function(): boolean,
 *   onUndo: function, onRobot: function, isAtRisk: function(): boolean}} page
 */
export function listenToGestures(root, page) {
  listenToDrops(root, page.onFiles);
  addEventListener("beforeunload", (event) => page.isAtRisk() && event.preventDefault());
  addEventListener("paste", (event) => {
    if (event.defaultPrevented || isTypedInto(event.target)) return;
    event.preventDefault(); // the caret moves into a cell, and the browser would paste there a second time
    const text = event.clipboardData.getData("text");
    if (text.trim()) page.onText(text);
  });
  addEventListener("keydown", (event) => {
    if (event.key === "F2" && !event.repeat) page.onRobot();
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase();
    const isUndo = key === "z" && page.canUndo() && !isTypedInto(event.target);
    if (key !== "s" && !isUndo) return;
    event.preventDefault();
    if (isUndo) page.onUndo();
    else if (!event.repeat) page.onSave();
  });
}

/** Files may be dropped anywhere. For anything else that is dragged, the browser does what it always does. */
function listenToDrops(root, onFiles) {
  const mark = (isOver) => root.classList.toggle("dropping", isOver);
  const hasFiles = ({ dataTransfer }) => dataTransfer.types.includes("Files");
  addEventListener("dragover", (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    mark(true);
  });
  addEventListener("dragleave", (event) => event.relatedTarget || mark(false));
  addEventListener("drop", (event) => {
    mark(false);
    if (!hasFiles(event)) return;
    event.preventDefault();
    onFiles([...event.dataTransfer.files]);
  });
}

function isTypedInto(element) {
  return element instanceof Element && element.matches("input[type=text]");
}
