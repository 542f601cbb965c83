// The page of `wpcal touchup`: which seams are taken, and the command that writes the program so.
import { decided } from "../touchup/command.js";

const boxes = [...document.querySelectorAll("input[type=checkbox]")];
const command = document.getElementById("command");
const words = command.textContent;

function show() {
  command.textContent = decided(
    words,
    boxes.filter((box) => !box.checked).map((box) => box.value),
  );
}

for (const box of boxes) {
  box.addEventListener("change", show);
  box.addEventListener("keydown", ({ key }) => {
    if (key !== "a" && key !== "r") return;
    box.checked = key === "a";
    show();
  });
}
show();
