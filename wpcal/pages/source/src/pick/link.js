// The way to the server that the page came from.
const LARGEST_FILE_BYTES = 5_900_000; // the server takes 8 MB, and base64 is a third more

/** Posts JSON; returns {answer} or {fault: {message, row}}, also where nobody answers. */
export async function post(action, body) {
  try {
    const response = await fetch(action, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(body),
    });
    if (response.ok) return await response.json();
    return { fault: { message: await response.text(), row: null } };
  } catch {
    const message =
      "wpcal no longer answers. Copy the rows with the button Copy, start wpcal pick again, and paste them there.";
    return { fault: { message, row: null }, isGone: true };
  }
}

/** Runs one task at a time; asked while it runs, it runs once more, with what then is. */
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
      isRunning = false; // also when a run fails: the next key tries again
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

/** Name and bytes of a file as `post("read", …)` takes them, or a fault when they cannot be had. */
export async function contentOf(file) {
  const wrong = (what) => ({ name: file.name, fault: { message: `${file.name}: ${what}` } });
  if (file.size > LARGEST_FILE_BYTES) return wrong("is too large for a list of taught points");
  try {
    return { name: file.name, base64: await base64Of(file) };
  } catch {
    return wrong("cannot be read"); // a folder, or gone
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
