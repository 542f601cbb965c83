// The way to the server that the page came from.

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
    const message = "wpcal no longer answers. Copy the table, start wpcal pick again, and paste it there.";
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

/** The bytes of a file as base64. */
export async function base64Of(file) {
  const url = await new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result);
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(file);
  });
  return url.slice(url.indexOf(",") + 1);
}
