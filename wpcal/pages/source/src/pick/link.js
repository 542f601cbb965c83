// The connection to the server that the page came from.
const LARGEST_FILE_BYTES = 5_900_000; // the server takes 8 MB, and base64 is a third longer

/** Codes of faults on which the page acts. The codes of the server are those of `wpcal.core.errors.ErrorCode`. */
export const FAULTS = Object.freeze({
  userFrameMissing: "user-frame-missing",
  noServer: "no-server",
  fileChanged: "file-changed",
  fileReadOnly: "file-read-only",
  conflict: "conflict",
});

/**
 * Posts JSON. A server that does not answer is a fault, too.
 *
 * @returns {Promise<{answer: object} | {fault: object}>}  a fault has `message`, `code`, and the `row` and `column` of
 *   the wrong cell, or null
 */
export async function post(action, body) {
  try {
    const response = await fetch(action, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(body),
    });
    if (response.ok) return await response.json();
    return { fault: faultOf(await response.text(), "refused") };
  } catch {
    const message =
      "wpcal no longer answers. Copy the rows with the button Copy, start wpcal pick again, and paste them there.";
    return { fault: faultOf(message, FAULTS.noServer) };
  }
}

function faultOf(message, code) {
  return { message, code, row: null, column: null };
}

/**
 * Runs one task at a time, and only the latest request: a request during a run starts one more run after it.
 *
 * @param {function(): Promise} run
 * @param {number} pauseMs  without a request, before a run starts
 * @returns {{ask: function, isIdle: boolean}}
 */
export function latestOnly(run, pauseMs) {
  let timer = null;
  let isRunning = false;
  let isAsked = false;
  const start = async () => {
    timer = null;
    isRunning = true;
    try {
      do {
        isAsked = false;
        await run();
      } while (isAsked);
    } finally {
      isRunning = false; // after a failed run, too: the next key starts another run
    }
  };
  return {
    ask() {
      if (isRunning) isAsked = true;
      else {
        clearTimeout(timer);
        timer = setTimeout(start, pauseMs);
      }
    },
    get isIdle() {
      return !isRunning && timer === null;
    },
  };
}

/** Name and bytes of a file as `post("read", …)` takes them, or a fault where the file cannot be read. */
export async function contentOf(file) {
  const wrong = (what) => ({ name: file.name, fault: faultOf(`${file.name}: ${what}`, "unreadable") });
  if (file.size > LARGEST_FILE_BYTES) return wrong("is too large for a list of taught points");
  try {
    return { name: file.name, base64: await base64Of(file) };
  } catch {
    return wrong("cannot be read"); // a folder, or a file that was deleted
  }
}

async function base64Of(file) {
  const url = await new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result);
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(file);
  });
  return url.slice(url.indexOf(",") + 1);
}
