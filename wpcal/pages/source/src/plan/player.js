// The time: a slider, a button that plays, and the speed.
import { el } from "../dom.js";

const SPEEDS = [1, 2, 5, 10];

/** `onTime(t)` is called whenever the time changes, s. */
export function buildPlayer(onTime) {
  const slider = el("input", {
    type: "range",
    min: 0,
    max: 1,
    step: "any",
    value: 0,
    "aria-label": "time, s",
    "data-test": "time",
  });
  const button = el("button", { type: "button", class: "play", "data-test": "play" }, "play");
  const speed = el(
    "select",
    { "aria-label": "speed" },
    SPEEDS.map((factor) => el("option", { value: factor }, `${factor} ×`)),
  );
  const clock = el("output", { "data-test": "clock" });
  const place = el("output", { class: "place", "data-test": "place" });
  const element = el("div", { class: "player" }, button, slider, clock, place, speed);
  let end = 1;
  let before = null; // time stamp of the frame before, while playing

  function seek(t) {
    slider.value = Math.min(Math.max(t, 0), end);
    clock.textContent = `${Number(slider.value).toFixed(1)} s of ${end.toFixed(1)} s`;
    onTime(Number(slider.value));
  }

  function stop() {
    before = null;
    button.textContent = "play";
  }

  function step(now) {
    if (before === null) return;
    const t = Number(slider.value) + (Number(speed.value) * (now - before)) / 1000;
    before = now;
    seek(t);
    if (t >= end) stop();
    else requestAnimationFrame(step);
  }

  slider.addEventListener("input", () => seek(Number(slider.value)));
  button.addEventListener("click", () => {
    if (before !== null) return stop();
    if (Number(slider.value) >= end) seek(0);
    button.textContent = "pause";
    before = performance.now();
    return requestAnimationFrame(step);
  });

  return {
    element,
    seek,
    say: (text) => (place.textContent = text),
    load(seconds, start) {
      stop();
      const first = end === 1 && Number(slider.value) === 0;
      end = seconds;
      slider.max = seconds;
      seek(first ? start : Number(slider.value));
    },
  };
}
